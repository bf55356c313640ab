# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of the bus, in real time between processes: what they cost the robot's end of it, Z1 to Z9."""

from __future__ import annotations

import math
import signal
import time
from typing import Callable, List, Sequence, Tuple

import numpy as np
from benchmarks import faults_goals
from benchmarks.fault_row import FaultRow
from benchmarks.faults_bus_base import on_a_base
from benchmarks.faults_bus_hostile import hostile
from benchmarks.faults_bus_rig import BusRig, resident_bytes, wait_for
from benchmarks.faults_bus_sockets import open_to_the_network

from edgefusion.bus.arbiter import Arbiter, Driver
from edgefusion.bus.freshness import CommandLimits, Freshness
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL, HEARTBEAT, IMAGE, MISSION
from edgefusion.clock import system_clock
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.service.cadence import Cadence
from edgefusion.types import Twist2D

CYCLE_S = 0.05
LIMITS = CommandLimits(4096, 50.0)
COMMANDS = 10_000
IMAGE_BYTES, IMAGES_HZ = 100_000, 30.0
STEADY_S = 10.0
MB = 1e6


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> List[FaultRow]:
    """tick: called after every run."""
    killed = [_router_killed(tick) for _ in range(seeds)]
    halted = [_operator_halted(seed, tick) for seed in range(seeds)]
    ended = [_driver_ends(seed, tick) for seed in range(seeds)]
    return [
        FaultRow("Z1", "router killed: the longest put", "5 ms", 0.005, [put_s for put_s, _ in killed]),
        FaultRow("Z1", "router started again: heard again", "in 5 s", 5.0, [back_s for _, back_s in killed]),
        FaultRow("Z2", "operator halted (SIGSTOP)", "nobody drives in 500 ms + a cycle", 0.55, halted),
        FaultRow("Z3", "cmd_vel ends", "velocity 0 in 300 ms", 0.3, ended),
        _roles(tick),
        *hostile(seeds, tick),
        *faults_goals.rows(seeds, tick),
        *_flood(tick),
        *_slow_watchers(tick),
        open_to_the_network(tick),
        *on_a_base(seeds, tick),
    ]


def _router_killed(tick: Callable[[], object]) -> Tuple[float, float]:
    with BusRig() as rig:
        publisher = Publisher(rig.member(), "robot", MISSION, Tagger(), "boot")
        subscriber = Subscriber(rig.member(), "robot/mission")
        longest_s = 0.0

        def heard() -> bool:
            nonlocal longest_s
            start_s = time.monotonic()
            publisher.put(String("news"), 0)
            longest_s = max(longest_s, time.monotonic() - start_s)
            return bool(subscriber.take())

        wait_for(heard)
        rig.router.kill()
        rig.router.wait()
        until_s = time.monotonic() + 1.0
        while time.monotonic() < until_s:
            heard()
            time.sleep(0.01)
        rig.start_router()
        start_s = time.monotonic()
        wait_for(heard)
        tick()
        return longest_s, time.monotonic() - start_s


def _operator_halted(seed: int, tick: Callable[[], object]) -> float:
    """Until nobody drives."""
    with BusRig() as rig:
        arbiter = Arbiter(round(0.2e9), operator_timeout_ns=round(0.5e9))
        inbox = Inbox(rig.member(), "robot", HEARTBEAT, lambda message: message, Freshness(LIMITS), to_the_moment=True)
        process = rig.join("operator", "operator")

        def drives() -> bool:
            for received_ns, _ in inbox.take(system_clock()):
                arbiter.heartbeat(received_ns)
            return arbiter.decide(system_clock()).driver is not Driver.NOBODY

        wait_for(lambda: inbox.waiting)
        drives()
        arbiter.resume(system_clock())
        _cycles_until(lambda: not drives(), 1.0 + 0.1 * np.random.default_rng(seed).random())
        process.send_signal(signal.SIGSTOP)
        start_s = time.monotonic()
        _cycles_until(lambda: not drives(), math.inf)
        tick()
        return time.monotonic() - start_s


def _driver_ends(seed: int, tick: Callable[[], object]) -> float:
    """From the last command that came until the velocity is zero."""
    with BusRig() as rig:
        arbiter, last_ns = Arbiter(round(0.2e9)), 0
        inbox = Inbox(rig.member(), "robot", CMD_VEL, to_cmd_vel, Freshness(LIMITS))
        rig.join("driver", "operator", 20, 20 + seed % 3)

        def moves() -> bool:
            nonlocal last_ns
            for last_ns, twist in inbox.take(system_clock()):
                arbiter.cmd_vel(last_ns, twist)
            return arbiter.decide(system_clock()).twist not in (None, Twist2D())

        _cycles_until(moves, math.inf)
        _cycles_until(lambda: not moves(), math.inf)
        tick()
        return (system_clock() - last_ns) / 1e9


def _cycles_until(condition: Callable[[], bool], limit_s: float) -> None:
    """As the base's loop does it: a look at the end of every cycle."""
    end_s = time.monotonic() + limit_s
    while not condition() and time.monotonic() < end_s:
        time.sleep(CYCLE_S)


def _roles(tick: Callable[[], object]) -> FaultRow:
    viewers = _counted("viewer", ("driver", 1000))
    tick()
    operators = _counted("operator", ("patient",))
    tick()
    remark = f"{viewers} of a viewer's, {operators} of an operator's {COMMANDS} commands counted"
    failed = (viewers, operators) != (0, COMMANDS)
    return FaultRow("Z5", "viewer and operator command", f"0 and {COMMANDS}", math.inf, remark=remark, failed=failed)


def _counted(role: str, player: Sequence[object]) -> int:
    """How many commands of this role count; the robot reports each."""
    with BusRig(max_command_hz=1000) as rig:
        robot = rig.member()
        reporter = Publisher(robot, "robot", MISSION, Tagger(), "boot")
        freshness = Freshness(CommandLimits(4096, 1e5, burst=COMMANDS))
        inbox = Inbox(robot, "robot", CMD_VEL, to_cmd_vel, freshness)
        process = rig.join(str(player[0]), role, *player[1:], COMMANDS)
        while process.poll() is None:
            time.sleep(0.0005)
            if inbox.take(system_clock()):
                reporter.put(String("one more"), 0)
        inbox.take(system_clock())
        return freshness.accepted


def _flood(tick: Callable[[], object]) -> List[FaultRow]:
    with BusRig() as rig:
        inbox = Inbox(rig.member(), "robot", CMD_VEL, to_cmd_vel, Freshness(LIMITS))
        process = rig.join("driver", "operator", 1e6, round(10_000 * STEADY_S))
        wait_for(lambda: inbox.take(system_clock()))
        before, cadence = resident_bytes(), Cadence(round(CYCLE_S * 1e9), system_clock, time.sleep)
        start_s = time.monotonic()
        while process.poll() is None:
            inbox.take(cadence.next())
        hz = inbox.freshness.accepted / (time.monotonic() - start_s)
        grown_mb = (resident_bytes() - before) / MB
    tick()
    late = cadence.lateness
    remark = f"{hz:.0f} commands a second counted, memory grew by {grown_mb:.1f} MB"
    return [
        FaultRow(
            "Z7", "10 kHz of an operator's commands: the loop is late, p99", "20 ms", 0.02, [late.p99_ms / 1e3],
            remark, failed=hz > 1.2 * LIMITS.max_hz or grown_mb > 3 * 5,
        )
    ]  # fmt: skip


def _slow_watchers(tick: Callable[[], object]) -> List[FaultRow]:
    """One that is slow, one that is halted, and one that is quick, while images go out."""
    with BusRig() as rig:
        publisher = Publisher(rig.member(), "robot", IMAGE, Tagger(), "boot")
        quick = Subscriber(rig.member(), "robot/image/compressed")
        rig.join("watcher", "viewer", 3600, 0.5)
        halted = rig.join("watcher", "viewer", 3600, 0)
        wait_for(lambda: publisher.wanted(system_clock()))
        halted.send_signal(signal.SIGSTOP)
        time.sleep(0.2)
        before, seconds, put_before = resident_bytes(), [], quick.received
        cadence = Cadence(round(1e9 / IMAGES_HZ), system_clock, time.sleep)
        for number in range(round(STEADY_S * IMAGES_HZ)):
            cadence.next()
            start_s = time.monotonic()
            publisher.put_bytes(b"x" * IMAGE_BYTES, number)
            seconds.append(time.monotonic() - start_s)
        time.sleep(0.5)
        lost = len(seconds) - (quick.received - put_before)
        grown_mb = (resident_bytes() - before) / MB
    tick()
    remark = f"the quick one lost {lost} of {len(seconds)}, memory grew by {grown_mb:.1f} MB"
    p99_s = float(np.percentile(seconds, 99))
    failed = lost > 0 or grown_mb > 3 * 20
    return [FaultRow("Z8", "slow and halted watchers: a put takes, p99", "5 ms", 0.005, [p99_s], remark, failed)]
