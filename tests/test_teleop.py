# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion teleop`: keys become velocities that count, and however it ends the robot is told to stand."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
from typing import List

import pytest

from bus_base import LIMITS, Base
from bus_lab import Lab, until
from edgefusion.bus import topics
from edgefusion.bus.freshness import Freshness
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.session import UnreachableError
from edgefusion.cli import main
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.tools.robot_keys import HELD_NS, Keys
from edgefusion.tools.teleop_loop import Teleop
from edgefusion.types import Twist2D

MS = 1_000_000


class Told:
    """A robot that notes what it is told, or hears nothing."""

    name = "robot"

    def __init__(self) -> None:
        self.twists: List[Twist2D] = []
        self.hears = True

    def drive(self, twist: Twist2D) -> None:
        if not self.hears:
            raise UnreachableError("nobody listens")
        self.twists.append(twist)


def test_a_held_key_drives_and_one_that_is_let_go_stops_once() -> None:
    now_ns, robot, keys = [0], Told(), Keys(0.2, 0.5)
    teleop = Teleop(robot, keys, lambda: now_ns[0])
    for _ in range(100):
        now_ns[0] += 10 * MS
        keys.press(b"w", now_ns[0])
        teleop.turn()
    assert robot.twists == [Twist2D(0.2)] * 20
    now_ns[0] += HELD_NS
    for _ in range(100):
        teleop.turn()
        now_ns[0] += 10 * MS
    assert robot.twists[20:] == [Twist2D()]


def test_without_a_key_nothing_is_told_so_that_the_mission_drives_on() -> None:
    robot, keys = Told(), Keys(0.2, 0.5)
    teleop = Teleop(robot, keys, lambda: 10**12)
    teleop.turn()
    teleop.stand()
    assert robot.twists == []


def test_what_was_pressed_while_nobody_listened_moves_nothing_later() -> None:
    now_ns, robot, keys = [10**12], Told(), Keys(0.2, 0.5)
    teleop = Teleop(robot, keys, lambda: now_ns[0])
    robot.hears = False
    keys.press(b"w", now_ns[0])
    teleop.turn()
    robot.hears = True
    now_ns[0] += 100 * MS
    teleop.turn()
    assert robot.twists == []


@pytest.mark.parametrize("end", [b"q", signal.SIGINT, signal.SIGTERM])
def test_in_a_terminal_keys_drive_and_the_last_that_is_told_is_to_stand(lab: Lab, end: bytes | signal.Signals) -> None:
    base = Base(lab)
    inbox = Inbox(base.session, "robot", topics.CMD_VEL, to_cmd_vel, Freshness(LIMITS))
    terminal, inside = pty.openpty()
    command = [sys.executable, "-m", "edgefusion.cli", "teleop", "--connect", lab.tcp]
    told: List[Twist2D] = []
    with subprocess.Popen(command, stdin=inside, stdout=inside, stderr=inside) as process:

        def listen() -> None:  # at a time at which no command is old: the last one is told just once
            told.extend(twist for _, twist in inbox.take(0))

        def is_driven() -> bool:
            os.write(terminal, b"w")
            if select.select([terminal], [], [], 0.02)[0]:
                os.read(terminal, 65536)
            listen()
            return Twist2D(0.2) in told

        def has_ended() -> bool:
            listen()
            return process.poll() is not None

        until(is_driven, 60)
        if isinstance(end, bytes):
            os.write(terminal, end)
        else:
            process.send_signal(end)
        until(has_ended, 60)
    until(lambda: listen() or told[-1] == Twist2D(), 60)
    os.close(terminal), os.close(inside)


def test_without_a_terminal_it_is_refused(lab: Lab, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["teleop", "--connect", lab.tcp]) == 2
    assert capsys.readouterr().err == "edgefusion: teleop: expected a terminal, for its keys\n"
