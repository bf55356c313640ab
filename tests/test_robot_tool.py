# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion robot`: what it shows, how it drives, and that it leaves a robot that was told to stop."""

from __future__ import annotations

import json
import os
import pty
import select
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path
from typing import Callable

import pytest

from camera_scenes import wait_until
from edgefusion.cli import main
from edgefusion.drivers.link import Link
from edgefusion.drivers.sip_command import Command
from edgefusion.tools.robot_keys import HELD_NS, Keys
from edgefusion.tools.robot_report import in_words
from edgefusion.tools.robot_watch import RobotWatch
from pioneer_scenes import MakeScene, SimulatedPioneer, scene
from served_pioneer import ServedPioneer

__all__ = ["scene"]
MS = 1_000_000
COMMAND = [sys.executable, "-m", "edgefusion.cli", "robot"]


def test_keys_drive_stop_and_switch_the_motors(scene: MakeScene) -> None:
    made, keys = scene(SimulatedPioneer()), Keys(0.2, 0.5)
    watch = RobotWatch("port", made.driver, keys, made.clock)
    watch.begin()
    for _ in range(30):
        keys.press(b"w", made.clock())
        watch.turn()
    assert made.robot.body.twist.v_mps == pytest.approx(0.2, abs=0.06)
    let_go_ns = made.clock()
    while watch.facts()["state"]["speed_mps"] > 0 or made.clock() < let_go_ns + 500 * MS:
        watch.turn()
    zeros = [ns for ns, told in made.robot.firmware.heard if ns > let_go_ns and told.number == Command.STOP]
    assert zeros[0] - let_go_ns <= HELD_NS + 20 * MS
    keys.press(b"m", made.clock())
    for _ in range(20):
        watch.turn()
    assert watch.facts()["state"]["motors_enabled"] is False


def test_a_robot_that_was_lost_is_found_again_and_counted(scene: MakeScene) -> None:
    made = scene(SimulatedPioneer())
    watch = RobotWatch("port", made.driver, None, made.clock)
    watch.begin()
    made.line.plugged = False
    for _ in range(3):
        assert not watch.turn()
        made.line.pause(2.0)
    told = watch.facts()
    assert (told["robot"], told["state"], told["health"]["state"]) == (None, None, "failed")
    assert len(in_words(told)) == 11
    made.line.plugged = True
    while not (watch.turn() and watch.has_state):
        pass
    assert watch.facts()["errors"]["reconnections"] == 1


def test_a_key_pressed_before_the_robot_was_found_does_not_move_it(scene: MakeScene) -> None:
    made, keys = scene(SimulatedPioneer()), Keys(0.2, 0.5)
    keys.press(b"wm", made.clock() + 60_000 * MS)  # held to this day
    watch = RobotWatch("port", made.driver, keys, made.clock)
    watch.begin()
    for _ in range(20):
        watch.turn()
    told = [(told.number, told.argument) for _, told in made.robot.firmware.heard]
    assert (Command.VEL, 200) not in told
    assert (Command.ENABLE, 0) not in told


def test_a_robot_is_told_of_in_lines_that_fit_a_terminal(scene: MakeScene) -> None:
    made = scene(SimulatedPioneer())
    made.robot.body.echoes = {3: 1.234, 8: 0.5}
    made.robot.body.bumpers = ((False, True, False, False, False), (False,) * 5)
    watch = RobotWatch("/dev/ttyUSB0", made.driver, None, made.clock)
    watch.begin()
    for _ in range(100):
        watch.turn()
    lines = in_words(watch.facts())
    assert lines[:6] == [
        "port     /dev/ttyUSB0, 38400 baud",
        "robot    Simulated_1: Pioneer p3dx-sh, firmware S.0",
        "health   failed: bumped: front 2",
        "battery  13.0 V, not charging",
        "flags    motors on, front bumper 2",
        "pose     x 0.000 m, y 0.000 m, 0.0 degrees",
    ]
    assert lines[7] == "front      far   far   far  1.23   far   far   far   far"
    assert lines[8].startswith("rear      0.50")
    assert max(map(len, lines)) < 80


def test_once_tells_it_once_and_leaves_the_motors_as_they_are(tmp_path: Path, capsys) -> None:
    with ServedPioneer(tmp_path / "port") as served:
        told = {"packets_per_s": 0}
        for _ in range(5):  # on a busy machine it may be slow, or silent for so long that it is taken for lost
            code, said = main(["robot", served.port, "--once", "--json"]), capsys.readouterr().out
            told = json.loads(said) if code == 0 else told
            if told["packets_per_s"] > 5:
                break
        assert told["packets_per_s"] > 5
        assert told["robot"]["subtype"] == "p3dx-sh"
        assert told["state"]["motors_enabled"] is False
        assert (Command.ENABLE, 1) not in served.told()


class Terminal:
    """`edgefusion robot` in a terminal of the test's own."""

    def __init__(self, port: str) -> None:
        self.end, inside = pty.openpty()
        self.process = subprocess.Popen([*COMMAND, port], stdin=inside, stdout=inside, stderr=inside)
        os.close(inside)
        self.shown = b""

    def until(self, done: Callable[[], bool], typed: bytes = b"", within_s: float = 20.0) -> None:
        """Types again and again until something is so."""
        end_s = time.monotonic() + within_s
        while not done():
            assert time.monotonic() < end_s, self.shown.decode()[-1500:]
            if typed:
                os.write(self.end, typed)
            if select.select([self.end], [], [], 0.05)[0]:
                self.shown += os.read(self.end, 65536)

    def code(self) -> int:
        """Of its end."""
        try:
            while os.read(self.end, 65536):
                pass
        except OSError:  # it has closed it
            pass
        os.close(self.end)
        return self.process.wait()


@pytest.mark.parametrize(("how", "code"), [("q", 0), ("SIGTERM", 0), ("SIGHUP", 0), ("SIGINT", 130)])
def test_in_a_terminal_it_drives_and_however_it_ends_the_robot_is_told_to_stop(
    tmp_path: Path, how: str, code: int
) -> None:
    with ServedPioneer(tmp_path / "port") as served:
        terminal = Terminal(served.port)
        terminal.until(lambda: b"motors on" in terminal.shown)
        terminal.until(lambda: (Command.VEL, 200) in served.told(), b"w")
        if how == "q":
            os.write(terminal.end, b"q")
        else:
            terminal.process.send_signal(getattr(signal, how))
        assert terminal.code() == code
        wait_until(lambda: served.told()[-1][0] == Command.CLOSE)  # a pty passes it on in its own time
        last = [number for number, _ in served.told()[-5:]]
        assert [n for n in last if n != Command.ENABLE][-4:] == [
            Command.STOP,
            Command.VEL,
            Command.RVEL,
            Command.CLOSE,
        ]


def test_no_key_halts_who_drives_and_the_terminal_is_as_it_was_afterwards(tmp_path: Path) -> None:
    with ServedPioneer(tmp_path / "port") as served:
        terminal = Terminal(served.port)
        before = termios.tcgetattr(terminal.end)
        terminal.until(lambda: b"motors on" in terminal.shown)
        flags, *_, keys = termios.tcgetattr(terminal.end)
        assert not flags & termios.IXON
        assert keys[termios.VSUSP] == keys[termios.VQUIT] == b"\0"
        assert keys[termios.VINTR] == before[6][termios.VINTR]
        terminal.until(lambda: (Command.VEL, 200) in served.told(), b"w")
        os.write(terminal.end, b"\x13\x1a\x1c")
        told = len(served.told())
        terminal.until(lambda: (Command.STOP, None) in served.told()[told:])
        os.write(terminal.end, b"q")
        terminal.process.wait()
        assert termios.tcgetattr(terminal.end) == before
        assert terminal.code() == 0


def test_what_was_typed_while_the_robot_was_lost_does_not_move_it(tmp_path: Path) -> None:
    with ServedPioneer(tmp_path / "port") as served:
        terminal = Terminal(served.port)
        terminal.until(lambda: (Command.VEL, 200) in served.told(), b"w")
        served.robot.power_cycle(time.monotonic_ns(), 0.5)
        terminal.until(lambda: b"health   failed: " in terminal.shown)
        os.write(terminal.end, b"w" * 100)
        before = len(served.told())
        terminal.until(lambda: b" 1 reconnections" in terminal.shown)
        assert (Command.VEL, 200) not in served.told()[before:]
        os.write(terminal.end, b"q")
        assert terminal.code() == 0


def test_a_port_that_another_holds_is_refused_with_its_name(tmp_path: Path) -> None:
    port = tmp_path / "port"
    with ServedPioneer(port):
        link = Link(str(port), 9600, "the first")
        link.open()
        done = subprocess.run([*COMMAND, str(port), "--once"], capture_output=True, text=True, timeout=20)
        link.close()
    assert done.returncode == 2
    assert f"held by the first (pid {os.getpid()})" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["/dev/no-such-robot"], 1, "/dev/no-such-robot: cannot be opened"),
        (["/dev/x", "--speed", "0"], 2, "--speed: expected more than 0, got 0"),
        (["/dev/x", "--turn-rate", "nan"], 2, "--turn-rate: expected more than 0, got nan"),
        (["/dev/x", "--config", "/none.toml"], 2, "/none.toml: cannot be read"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(arguments: list[str], code: int, said: str, capsys) -> None:
    assert main(["robot", *arguments]) == code
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
