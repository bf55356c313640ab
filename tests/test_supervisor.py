# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The supervisor with real processes: children that live, crash, hang, do not end; a robot on a pty; a fake systemd."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Callable

import pytest

from edgefusion.drivers.sip_command import Command
from edgefusion.service.utc import taken_offset_ns
from edgefusion.types import Twist2D
from fake_systemd import PATIENCE_S, FakeSystemd, child
from served_pioneer import ServedPioneer


def wait_for(holds: Callable[[], object]) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < deadline_s, "it did not come to it"
        time.sleep(0.01)


def is_alive(pid: int) -> bool:
    """A zombie is not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_it_says_when_it_is_ready_how_all_are_and_that_it_ends_and_ends_well(tmp_path: Path) -> None:
    with FakeSystemd(tmp_path, child("bus", "well", "routes"), child("base", "well", "drives")) as systemd:
        systemd.ready()
        systemd.status("bus ok: routes; base ok: drives")
        code, told = systemd.end()
        assert code == 0 and "asked to by SIGTERM" in told
        assert "STOPPING=1" in systemd.drain()
        assert systemd.heard.count("READY=1") == systemd.heard.count("STOPPING=1") == 1


def test_children_have_one_offset_to_utc_a_session_of_their_own_and_hear_of_the_others(tmp_path: Path) -> None:
    vision = child("vision", "tells", nice=7, oom_score_adj=300)
    with FakeSystemd(tmp_path, child("base", "tells"), vision) as systemd:
        says = [part.split(": ")[1].split() for part in systemd.status("[vision=ok]", "[base=ok]").split("; ")]
        own = os.nice(0)
        assert [words[1:4] for words in says] == [["False", "True", str(nice)] for nice in (own, min(19, own + 7))]
        assert says[1][4] == "300"
        assert says[0][0] == says[1][0]
        assert abs(int(says[0][0]) - taken_offset_ns()) < 60_000_000_000


def test_the_watchdog_is_fed_for_as_long_as_its_loop_lives(tmp_path: Path) -> None:
    with FakeSystemd(tmp_path, child("bus", "well"), watchdog_s=0.2) as systemd:
        systemd.ready()
        for _ in range(3):
            systemd.until(lambda line: line == "WATCHDOG=1")
        os.kill(systemd.process.pid, signal.SIGSTOP)
        os.waitpid(systemd.process.pid, os.WUNTRACED)
        systemd.drain()
        time.sleep(0.5)
        assert systemd.drain() == []
        os.kill(systemd.process.pid, signal.SIGCONT)
        systemd.until(lambda line: line == "WATCHDOG=1")


def test_who_crashes_or_cannot_be_run_is_given_up_and_the_rest_lives(tmp_path: Path) -> None:
    some = {"give_up": (2, 600.0), "required": False, "first_pause_s": 0.01}
    vision, missing = (
        child("vision", "crash", **some),
        {**child("bus", "well", **some), "argv": [str(tmp_path / "none")]},
    )
    with FakeSystemd(tmp_path, missing, child("base", "well"), vision) as systemd:
        status = systemd.status("base ok", "vision failed: given up after 2 failures: killed by SIGSEGV")
        assert "bus failed: given up after 2 failures: cannot be run: [Errno 2] No such file" in status
        code, told = systemd.end()
        assert code == 0 and told.count("vision: started") <= 2


def test_all_ends_where_a_child_that_is_needed_is_given_up(tmp_path: Path) -> None:
    vision = child("vision", "crash", give_up=(1, 600.0))
    with FakeSystemd(tmp_path, child("base", "well"), vision) as systemd:
        code, told = systemd.wait()
    assert code == 1 and "ends: vision was given up" in told


def test_who_hangs_is_killed_with_all_that_it_has_started(tmp_path: Path) -> None:
    pids = tmp_path / "pids"
    with FakeSystemd(tmp_path, child("vision", "hang", str(pids), silence_s=0.2, first_pause_s=0.01)) as systemd:
        systemd.status("vision failed: silent for 0.2 s")
        wait_for(lambda: len(pids.read_text().splitlines()) >= 2)
        first = pids.read_text().splitlines()[0].split()
        wait_for(lambda: not any(is_alive(int(pid)) for pid in first))
    wait_for(lambda: not any(is_alive(int(pid)) for pid in pids.read_text().split()))


def test_what_is_no_status_is_no_sign_of_life(tmp_path: Path) -> None:
    silence_s = 1.2  # so long that it is well for longer than systemd waits to be told of a change
    with FakeSystemd(tmp_path, child("vision", "garbage", silence_s=silence_s)) as systemd:
        systemd.status("vision ok: sense")
        systemd.status("vision failed: silent for 1.2 s")


def drives(robot: ServedPioneer) -> bool:
    return robot.body.twist.v_mps > 0.1


def heard_since(robot: ServedPioneer, ns: int) -> list[int]:
    return [told.number for heard_ns, told in robot.robot.heard if heard_ns >= ns]


def pid_of(systemd: FakeSystemd) -> int:
    """The supervisor's only child; where it has none just now, the next one."""
    pid, found = systemd.process.pid, []

    def has_one() -> bool:
        found[:] = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        return bool(found)

    wait_for(has_one)
    return int(found[0])


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_robot_whose_base_is_killed_or_hangs_is_stopped_before_the_next_base_speaks_to_it(
    tmp_path: Path, number: int
) -> None:
    base = child("base", "drive", str(tmp_path / "robot"), str(tmp_path), drives=True, silence_s=2.0)
    with ServedPioneer(tmp_path / "robot") as robot, FakeSystemd(tmp_path, base) as systemd:
        wait_for(lambda: drives(robot))
        os.kill(pid_of(systemd), number)
        killed_ns = time.monotonic_ns()
        wait_for(lambda: Command.CLOSE in heard_since(robot, killed_ns))  # the next one ends the old session
        _, told = systemd.end()
    assert ("killed by SIGKILL" if number == signal.SIGKILL else "silent for 2 s") in told
    assert "its robot was told to stop" in told and "at 38400 baud" in told
    heard = heard_since(robot, killed_ns)
    last_stop = heard[: heard.index(Command.CLOSE)]
    # The next one's own greeting is a stop and a pulse, where the session is an old one.
    assert last_stop.count(Command.STOP) > 1 and last_stop[-2:] == [Command.STOP, Command.PULSE]


def test_a_base_that_does_not_end_is_killed_and_its_robot_stopped(tmp_path: Path) -> None:
    base = child("base", "drive", str(tmp_path / "robot"), str(tmp_path), drives=True)
    with ServedPioneer(tmp_path / "robot") as robot, FakeSystemd(tmp_path, base) as systemd:
        wait_for(lambda: drives(robot))
        os.kill(pid_of(systemd), signal.SIGSTOP)
        code, told = systemd.end()
        assert code == 0 and "base: does not end; killed" in told and "its robot was told to stop" in told
        wait_for(lambda: robot.body.twist == Twist2D())


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGABRT])
def test_a_robot_stops_when_the_supervisor_itself_is_killed(tmp_path: Path, number: int) -> None:
    base = child("base", "drive", str(tmp_path / "robot"), str(tmp_path), drives=True)
    with ServedPioneer(tmp_path / "robot") as robot, FakeSystemd(tmp_path, base) as systemd:
        wait_for(lambda: drives(robot))
        pid = pid_of(systemd)
        assert systemd.end(number)[0] == -number
        wait_for(lambda: robot.told()[-1:] == [(Command.CLOSE, 1)])
        wait_for(lambda: not is_alive(pid))
