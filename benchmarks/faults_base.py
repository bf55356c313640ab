# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Y3 and Y5 in real time: a base that raises or is told to end, and one whose devices come after it."""

from __future__ import annotations

import signal
import subprocess
import threading
import time
from contextlib import contextmanager, suppress
from typing import Any, Callable, Iterator, List, Tuple, Type

import numpy as np
from benchmarks.fault_lab import FaultLab
from benchmarks.fault_row import FaultRow
from benchmarks.faults_base_rig import DEVICES, ENDS, BaseRig, driving, hall

from edgefusion.config import Config, LaserConfig, MissionConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.errors import RefusedError
from edgefusion.service.base import Base
from edgefusion.service.base_devices import open_base
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.robot_device import RobotDevice
from edgefusion.types import Goal, Pose2D

TRAPS: Tuple[Tuple[Type[Any], str], ...] = (
    (Pioneer, "poll"),
    (Pioneer, "drive"),
    (Lms2xx, "read"),
    (RobotDevice, "poll"),
    (RobotDevice, "drive"),
    (BaseLoop, "step"),
    (Link, "read"),
)
AIM, LIMIT_S, _ASK_S, ENDS_S = "to stop, 100 ms", 0.1, 0.02, 30.0
_CONFIG = Config(mission=MissionConfig(interest=()), laser=LaserConfig(baudrate=500000))

Tick = Callable[[], object]


def rows(seeds: int, tick: Tick = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each run."""
    return [*raising(seeds, tick), *told_to_end(seeds, tick), *ended_as_it_starts(seeds, tick), *booting(seeds, tick)]


def raising(seeds: int, tick: Tick) -> List[FaultRow]:
    """Y3, an error at each call in turn, from a moment on."""
    seconds: List[float] = []
    unsaid = 0
    for seed in range(seeds):
        for owner, name in TRAPS:
            with _trapped(owner, name) as sprung, FaultLab(seed) as lab:
                lab.driving()
                sprung.set()
                seconds.append(lab.stopped_after_s(time.monotonic_ns()))
                lab.base.end()
                lab.wait_for(lambda: not lab.devices.robot.open)
                unsaid += lab.devices.robot.heard[-1][1].number not in ENDS
            tick()
    remark = f"{len(TRAPS)} calls; the last that the robot heard was another {unsaid} times"
    return [FaultRow("Y3", "any call raises, until told to stop", AIM, LIMIT_S, seconds, remark, unsaid > 0)]


@contextmanager
def _trapped(owner: Type[Any], name: str) -> Iterator[threading.Event]:
    """Once what it gives is set, that raises each time."""
    call, hook, sprung = getattr(owner, name), threading.excepthook, threading.Event()

    def trap(*arguments: Any) -> Any:
        if sprung.is_set():
            raise ZeroDivisionError("oops")
        return call(*arguments)

    setattr(owner, name, trap)
    threading.excepthook = lambda _: None  # it is said that base's thread ended by it
    try:
        yield sprung
    finally:
        setattr(owner, name, call)
        threading.excepthook = hook


def told_to_end(seeds: int, tick: Tick) -> List[FaultRow]:
    """Y3, by a signal at speed."""
    found: List[FaultRow] = []
    for number, word in ((signal.SIGTERM, "SIGTERM"), (signal.SIGINT, "Ctrl-C")):
        seconds: List[float] = []
        unsaid = 0
        for seed in range(seeds):
            with driving(seed) as (rig, _):
                time.sleep(0.1 * float(np.random.default_rng(seed).random()))
                told_ns = time.monotonic_ns()
                rig.processes["base"].send_signal(number)
                unsaid += _drives_when_ended(rig)
                seconds.append((rig.motions()[-1][0] - told_ns) / 1e9)
            tick()
        remark = f"the last that the robot heard was another {unsaid} times"
        what = f"{word} at speed, until the last that the robot is told"
        found.append(FaultRow("Y3", what, AIM, LIMIT_S, seconds, remark, unsaid > 0))
    return found


def ended_as_it_starts(seeds: int, tick: Tick) -> List[FaultRow]:
    """Y3, by a signal at any moment before it drives."""
    unsaid = 0
    for seed in range(seeds):
        with hall(seed) as rig:
            base = rig.start("base")
            time.sleep(float(np.random.default_rng(seed).uniform(0.3, 3.0)))
            base.send_signal(signal.SIGTERM)
            unsaid += _drives_when_ended(rig)
        tick()
    remark = f"the last that the robot heard was another {unsaid} times"
    return [FaultRow("Y3", "SIGTERM as it starts", "to stop, or nothing", float("inf"), [], remark, unsaid > 0)]


def _drives_when_ended(rig: BaseRig) -> bool:
    """Whether a robot that heard anything of that base heard something else last than to stand, or base goes on."""
    try:
        rig.processes["base"].wait(ENDS_S)
    except subprocess.TimeoutExpired:
        return True
    time.sleep(0.05)  # what is on the wire
    motions = rig.motions()
    return rig.robot.open or (bool(motions) and not motions[-1][1])


def booting(seeds: int, tick: Tick) -> List[FaultRow]:
    """Y5."""
    found: List[FaultRow] = []
    for word, switched in (("plugged in", False), ("switched on", True)):
        seconds: List[float] = []
        moved = 0
        for seed in range(seeds):
            for order in (DEVICES, DEVICES[::-1]):
                with hall(seed, DEVICES if switched else ()) as rig:
                    ready_s, early = _booted(rig, order, switched, np.random.default_rng(seed))
                seconds.append(ready_s)
                moved += early
            tick()
        remark = f"told to move before {moved} times"
        what = f"devices {word} one after the other, until a goal is taken"
        found.append(FaultRow("Y5", what, "3 s after the last", 3.0, seconds, remark, moved > 0))
    return found


def _booted(rig: BaseRig, order: Tuple[str, ...], switched: bool, rng: np.random.Generator) -> Tuple[float, int]:
    """How long after the last one it was ready [s], and how often it was told to move before."""
    for name in order if switched else ():
        rig.switch_off(name)
    base = open_base(_CONFIG, str(rig.folder / "robot"), str(rig.folder / "laser"), lock_folder=rig.folder)
    thread = threading.Thread(target=base.run)
    thread.start()
    try:
        for name in order:
            end_s = time.monotonic() + float(rng.uniform(0.5, 2.5))
            while time.monotonic() < end_s:
                _goes(base)
            rig.switch_on(name) if switched else rig.plug(name)
        arrived_ns = time.monotonic_ns()
        rig.wait(lambda: _goes(base))
        ready_ns = time.monotonic_ns()
        rig.wait(lambda: any(not stands for _, stands in rig.motions()))
        return (ready_ns - arrived_ns) / 1e9, sum(not stands and ns < arrived_ns for ns, stands in rig.motions())
    finally:
        base.end()
        thread.join()


def _goes(base: Base) -> bool:
    with suppress(RefusedError, TimeoutError):
        base.goto([Goal("far", Pose2D(10.0, 0.0))])
        return True
    time.sleep(_ASK_S)
    return False
