# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The last stop: it reaches a robot whose base is dead, at whatever speed its line is, and says so when it does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from edgefusion.drivers.pioneer_connect import HOST_BAUDS
from edgefusion.drivers.port_lock import PortBusyError, PortLock
from edgefusion.drivers.sip_command import Command, command
from edgefusion.errors import RefusedError
from edgefusion.service.last_stop import WITHIN_NS, RobotLine, robot_line, stop_robot
from edgefusion.sim.wire_tcp import TcpWire
from edgefusion.types import Twist2D
from pioneer_scenes import MakeScene, Scene, SimulatedPioneer, scene
from served_pioneer import ServedPioneer

__all__ = ["scene"]
PORT = "/dev/ttyROBOT"
MS = 1_000_000


@pytest.fixture
def driving(scene: MakeScene, tmp_path: Path) -> Scene:
    """A robot that drives at 38400 baud, and whose base says no more."""
    made = scene(SimulatedPioneer()).started()
    made.run(1.5, Twist2D(0.3))
    assert made.link.baudrate == 38400 and made.robot.body.twist.v_mps > 0.25
    made.locks = tmp_path / "locks"  # a dead base holds none
    made.locks.mkdir()
    return made


def stop(made: Scene, baudrate: int = 38400, by_ns: int | None = None, pause=None) -> int:
    pause = pause or made.line.pause
    return stop_robot(RobotLine(PORT, baudrate), by_ns, made.clock, pause, made.locks)


def stops_heard(made: Scene, since_ns: int) -> list[float]:
    """How long after that time [s]."""
    return [
        (ns - since_ns) / 1e9
        for ns, told in made.robot.firmware.heard
        if told.number == Command.STOP and ns >= since_ns
    ]


def test_a_driving_robot_hears_it_at_once_and_does_not_drive_on_when_somebody_speaks_again(driving: Scene) -> None:
    died_ns = driving.clock()
    assert stop(driving) == 38400
    assert stops_heard(driving, died_ns)[0] <= 0.05
    for _ in range(20):
        driving.line.pause(0.1)
        driving.robot.receive(command(Command.PULSE), 38400, driving.clock())
    assert driving.robot.body.twist == Twist2D()


@pytest.mark.parametrize("baudrate", HOST_BAUDS)
def test_it_is_found_at_another_speed_than_base_said_last(driving: Scene, baudrate: int) -> None:
    begin_ns = driving.clock()
    assert stop(driving, baudrate) == 38400
    assert driving.clock() - begin_ns < WITHIN_NS
    assert stops_heard(driving, begin_ns)
    assert len(driving.line.written[-1][1]) > 255  # also one that waits for the rest of the longest packet hears one


@pytest.mark.parametrize("baudrate", [38400, 57600, 115200])
@pytest.mark.parametrize("whole", range(9))
def test_a_packet_that_was_cut_off_does_not_swallow_it(driving: Scene, whole: int, baudrate: int) -> None:
    driving.robot.receive(command(Command.VEL, 300)[:whole], 38400, driving.clock())
    begin_ns = driving.clock()
    assert stop(driving, baudrate) == 38400
    driving.line.pause(0.1)
    driving.robot.receive(command(Command.PULSE), 38400, driving.clock())
    assert stops_heard(driving, begin_ns)[0] <= (0.2 if baudrate == 38400 else WITHIN_NS / 1e9)
    assert [told.number for _, told in driving.robot.firmware.heard[-4:-1]] == [Command.STOP, Command.VEL, Command.RVEL]


def test_a_port_that_somebody_else_has_is_left_to_them(driving: Scene) -> None:
    other = PortLock(PORT, "edgefusion robot", driving.locks)
    other.acquire()
    written = len(driving.line.written)
    begin_ns = driving.clock()
    with pytest.raises(PortBusyError, match="it is held by edgefusion robot"):
        stop(driving)
    assert driving.clock() - begin_ns <= 600 * MS
    other.release()
    assert len(driving.line.written) == written


def test_a_port_that_is_just_being_let_go_is_waited_for(driving: Scene) -> None:
    other, begin_ns = PortLock(PORT, "edgefusion base", driving.locks), driving.clock()
    other.acquire()

    def pause(seconds: float) -> None:
        driving.line.pause(seconds)
        if driving.clock() - begin_ns > 300 * MS:
            other.release()

    assert stop(driving, pause=pause) == 38400
    assert 0.3 < stops_heard(driving, begin_ns)[0] < 0.4


def test_a_port_that_comes_back_is_used_and_one_that_does_not_is_named(driving: Scene) -> None:
    driving.line.plugged, begin_ns = False, driving.clock()
    with pytest.raises(RuntimeError, match=f"{PORT}: cannot be opened"):
        stop(driving)
    assert driving.clock() - begin_ns == pytest.approx(WITHIN_NS, abs=50 * MS)

    def pause(seconds: float) -> None:
        driving.line.pause(seconds)
        driving.line.plugged = True

    assert stop(driving, pause=pause) == 38400


def test_a_line_that_takes_nothing_is_said_to(driving: Scene) -> None:
    driving.line.blocked = True
    with pytest.raises(RuntimeError, match="took no bytes"):
        stop(driving)


def test_a_robot_that_does_not_report_was_told_all_the_same(driving: Scene) -> None:
    driving.robot.firmware.power_cycle(driving.clock())
    written = len(driving.line.written)
    with pytest.raises(RuntimeError, match="told to stop, but it does not report"):
        stop(driving)
    assert len(driving.line.written) - written == len(HOST_BAUDS) + 1


def test_without_time_it_is_told_once(driving: Scene) -> None:
    begin_ns = driving.clock()
    with pytest.raises(RuntimeError, match="does not report"):
        stop(driving, by_ns=begin_ns)
    assert stops_heard(driving, begin_ns)
    assert driving.clock() - begin_ns < 50 * MS


def test_nobody_holds_the_port_afterwards(driving: Scene) -> None:
    stop(driving)
    lock = PortLock(PORT, "the next base", driving.locks)
    lock.acquire()
    lock.release()


class Networked(ServedPioneer):
    """Behind an adapter from serial to Ethernet."""

    def __enter__(self) -> Networked:
        self._wire = TcpWire(0)
        self.port = self._wire.name
        self._thread.start()
        return self


def test_a_robot_behind_a_network_is_stopped_too(tmp_path: Path) -> None:
    from edgefusion.config import BaseConfig, PioneerConfig
    from edgefusion.drivers.link import Link
    from edgefusion.drivers.pioneer import Pioneer

    with Networked(tmp_path / "robot") as served:
        link = Link(served.port, 9600, lock_folder=tmp_path)
        driver = Pioneer(link, PioneerConfig(), BaseConfig())
        driver.start()
        driver.drive(Twist2D(0.3))
        told = len(served.told())
        link.close()  # as the kernel does it for a dead process: nothing is said
        assert stop_robot(RobotLine(served.port, 9600), lock_folder=tmp_path) == 9600
        assert (Command.STOP, None) in served.told()[told:]


def test_a_status_names_the_robots_line() -> None:
    assert robot_line({"port": "/dev/ttyUSB0", "baudrate": 38400, "says": "drives"}) == RobotLine("/dev/ttyUSB0", 38400)
    assert robot_line({"port": "socket://10.0.0.2:8101", "baudrate": None}) == RobotLine("socket://10.0.0.2:8101", 9600)
    assert robot_line({}) is robot_line({"says": "starts", "port": None}) is None


@pytest.mark.parametrize(
    ("status", "name"),
    [
        ({"port": ""}, "port"),
        ({"port": 3, "baudrate": 9600}, "port"),
        ({"port": "/dev/ttyUSB0"}, "baudrate"),
        ({"port": "/dev/ttyUSB0", "baudrate": "9600"}, "baudrate"),
        ({"port": "/dev/ttyUSB0", "baudrate": 500000}, "baudrate"),
    ],
)
def test_what_is_no_line_is_refused(status: dict[str, object], name: str) -> None:
    with pytest.raises(RefusedError, match=f"^{name}: expected"):
        robot_line(status)
