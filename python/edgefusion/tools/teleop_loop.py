# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Driving a robot over the bus by keys, and what is told of it meanwhile."""

from __future__ import annotations

import sys
import time
from typing import Sequence

from edgefusion.bus.client import Robot
from edgefusion.bus.session import UnreachableError
from edgefusion.clock import Clock
from edgefusion.tools.robot_keys import Keys
from edgefusion.tools.terminal import Screen, keys_at_once, pressed
from edgefusion.tools.watch_report import Watched, in_words
from edgefusion.types import Twist2D

HELP = (
    "arrows or W A S D drive, space stops, Q quits",
    "let go, and it stops within half a second; `edgefusion resume` gives it back to its mission",
)
_DRIVE_NS, _SCREEN_NS, _PAUSE_S = 50_000_000, 200_000_000, 0.01


class Teleop:
    """Tells the robot what the keys say, twenty times a second while it moves; a robot that should stand, once: it
    stands by itself soon after the last command."""

    def __init__(self, robot: Robot, keys: Keys, clock: Clock) -> None:
        self._robot, self._keys, self._clock = robot, keys, clock
        self._told, self._told_ns = Twist2D(), 0
        self._trouble = ""

    def turn(self) -> None:
        """Tells it what is to be told now. Where nobody listens, what is pressed is of no account later."""
        now_ns = self._clock()
        twist = self._keys.twist(now_ns)
        if twist == self._told and (twist == Twist2D() or now_ns - self._told_ns < _DRIVE_NS):
            return
        try:
            self._robot.drive(twist)
            self._told, self._told_ns, self._trouble = twist, now_ns, ""
        except UnreachableError as error:
            self._keys.let_go()
            self._told, self._trouble = Twist2D(), str(error)

    def stand(self) -> None:
        """The last that the robot hears, if it was told to drive."""
        self._keys.let_go()
        self.turn()

    def lines(self) -> Sequence[str]:
        """How the robot is, and what it is told."""
        twist = f"{self._told.v_mps:.2f} m/s, {self._told.w_radps:.2f} rad/s"
        told = f"told     {self._trouble or twist}"
        return [*in_words(Watched(self._robot.name, self._robot.status, None)), told, *HELP]


def drive_in_terminal(teleop: Teleop, keys: Keys) -> None:
    """Until Q, drawn in the terminal five times a second. However it ends, the robot is told to stand."""
    terminal, screen, shown_ns = sys.stdin.fileno(), Screen(sys.stdout), 0
    with keys_at_once(terminal):
        try:
            while not keys.quit:
                keys.press(pressed(terminal), time.monotonic_ns())
                teleop.turn()
                if time.monotonic_ns() - shown_ns >= _SCREEN_NS:
                    shown_ns = time.monotonic_ns()
                    screen.show(teleop.lines())
                time.sleep(_PAUSE_S)
        finally:
            teleop.stand()
