# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What goes wrong in a soak, and what the robot has to do then: stand within a time, or drive on."""

from __future__ import annotations

import signal
import time
from dataclasses import dataclass
from typing import Callable, Literal, Tuple

from benchmarks.soak_rig import SoakRig

from edgefusion.sim.faults import parse_fault

Act = Callable[[SoakRig], object]
Wanted = Literal["told", "halted", "heard", "nothing"]

GAP_S = 0.3
"""A robot that drives on hears something at least so often: its firmware waits 2 s."""


def _mend(rig: SoakRig) -> None:
    rig.devices.mend()


def _nothing(_: SoakRig) -> None:
    """It mends itself."""


@dataclass(frozen=True)
class SoakFault:
    """wanted: that the robot is told to stand, or that its wheels stand, within the limit [s]; that it hears commands
    at least so often; or nothing but that it touches nothing and drives again. early: only in the first third, so that
    later the processes live long enough to see whether they grow. deaf: until it stands the robot hears nothing, and
    nobody can keep it from what is before it."""

    name: str
    inject: Act
    mend: Act = _mend
    wanted: Wanted = "nothing"
    limit_s: float = 0.0
    early: bool = False
    deaf: bool = False

    @property
    def mends_itself(self) -> bool:
        return self.mend is _nothing


def _device(text: str, wanted: Wanted = "nothing", limit_s: float = 0.0, deaf: bool = False) -> SoakFault:
    def inject(rig: SoakRig) -> None:
        rig.devices.inject(parse_fault(text), time.monotonic_ns())

    return SoakFault(text, inject, _mend, wanted, limit_s, deaf=deaf)


def _signal(name: str, number: signal.Signals, wanted: Wanted, limit_s: float, early: bool) -> SoakFault:
    def inject(rig: SoakRig) -> None:
        rig.kill(name, number)

    return SoakFault(f"{name} {number.name}", inject, _nothing, wanted, limit_s, early)


def _player(who: str, name: str) -> SoakFault:
    return SoakFault(name, lambda rig: rig.play(who), lambda rig: rig.leave(who), "heard", GAP_S)


def _unplug(rig: SoakRig) -> None:
    rig.devices.unplug_laser()


def _plug(rig: SoakRig) -> None:
    rig.devices.plug_laser()


def _press(rig: SoakRig) -> None:
    rig.devices.robot.e_stop_pressed = True


def _release(rig: SoakRig) -> None:
    rig.devices.robot.e_stop_pressed = False


def _motors_off(rig: SoakRig) -> None:
    rig.devices.robot.drive.motors = False


def _power_cycle(rig: SoakRig) -> None:
    rig.devices.robot.power_cycle(time.monotonic_ns())


FAULTS: Tuple[SoakFault, ...] = (
    _device("laser=off", "told", 0.2),
    _device("laser=off:300", "told", 0.2),
    _device("laser=stuck", "told", 0.19),
    _device("laser=garbage:0.01", "told", 0.2),
    _device("laser=delayed:0.3", "told", 0.22),
    _device("laser=garbage:0.001"),
    _device("laser=wrong"),
    _device("laser=slow:4"),
    _device("laser=intermittent:0.5"),
    SoakFault("laser unplugged", _unplug, _plug, "told", 0.1),
    _device("robot=off", "halted", 4.0, deaf=True),  # it hears nothing: its firmware waits 2 s, and brakes from 0.5 m/s
    _device("robot=stuck", "told", 1.1),
    _device("robot=garbage:0.01"),
    _device("robot=wrong"),
    _device("robot=slow:4"),
    _device("robot=delayed:0.3"),
    _device("robot=intermittent:0.5"),
    SoakFault("emergency stop", _press, _release, "told", 0.15),
    SoakFault("motors switched off", _motors_off, _nothing, "told", 0.15),
    SoakFault("robot's power off for 0.5 s", _power_cycle, _nothing, "halted", 0.5),
    _device("camera=off", "heard", GAP_S),
    _device("camera=stuck", "heard", GAP_S),
    _device("camera=wrong", "heard", GAP_S),
    _device("camera=intermittent:0.5", "heard", GAP_S),
    _signal("base", signal.SIGKILL, "told", 0.5, True),
    _signal("base", signal.SIGSTOP, "told", 2.0, True),
    _signal("vision", signal.SIGKILL, "heard", GAP_S, True),
    _signal("vision", signal.SIGSEGV, "heard", GAP_S, True),
    _signal("vision", signal.SIGSTOP, "heard", GAP_S, True),
    _signal("bus", signal.SIGKILL, "heard", GAP_S, False),
    _signal("bus", signal.SIGSTOP, "heard", GAP_S, False),
    _player("slow", "a slow watcher"),
    _player("hostile", "200 hostile payloads a second"),
)
