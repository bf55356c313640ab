# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the doctor says of a robot and a laser, and that the robot is not moved by it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest

from doctor_scenes import examination, on_a_line, told
from edgefusion.drivers.port_lock import PortLock
from edgefusion.drivers.sip_command import Command
from edgefusion.sim.fault_frames import LMS, SIP
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.sim.sip_robot_character import H8, Character
from edgefusion.tools.doctor_finding import Finding
from edgefusion.tools.doctor_laser import check_laser
from edgefusion.tools.doctor_robot import check_robot
from edgefusion.types import Pose2D, Scan
from lms_scenes import LIVELY, ROOM
from pioneer_scenes import SimulatedPioneer

START_NS = 5 * 10**9
MOVING = {Command.VEL, Command.RVEL, Command.VEL2, Command.HEAD, Command.DHEAD}


def scanner(**settings: Any) -> LmsScanner:
    rng = np.random.default_rng(1)

    def scan_at(stamp_ns: int, spec: LaserSpec) -> Scan:
        return SimLaser(spec).scan(stamp_ns, ROOM, lambda _: Pose2D(0.2, -0.1), rng)[0]

    return LmsScanner(scan_at, START_NS, real=LIVELY, **settings)


@pytest.fixture
def look(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Finding]:
    """look(check, device, **configuration): the one finding."""

    def examined(check: Any, device: Any, **changes: Any) -> Finding:
        line = on_a_line(monkeypatch, device)
        (finding,) = check(examination(tmp_path, **changes), line.clock, line.pause)
        assert finding.check == check.__name__[len("check_") :]
        return finding

    return examined


def test_a_robot_that_is_well_is_named_and_left_standing_with_its_session_closed(look: Any) -> None:
    robot = SimulatedPioneer()
    finding = look(check_robot, robot)
    assert told([finding]) == ["ok robot"]
    assert finding.text == "Simulated_1: Pioneer p3dx-sh, firmware S.0, 38400 baud, 13.0 V, 10 reports a second"
    assert not robot.firmware.open
    assert not robot.firmware.drive.motors


@pytest.mark.parametrize("motors", [False, True])
@pytest.mark.parametrize("character", [Character("p3dx-sh", 1.0), H8])
def test_the_robot_is_told_nothing_that_moves_it_and_its_motors_are_not_enabled(
    look: Any, character: Character, motors: bool
) -> None:
    robot = SimulatedPioneer(character)
    robot.firmware.drive.motors = motors
    before = robot.body.odometry
    assert told([look(check_robot, robot, robot={"enable_motors": True})]) == ["ok robot"]
    heard = [(each.number, each.argument) for _, each in robot.firmware.heard]
    assert (Command.ENABLE, 1) not in heard
    assert {argument for number, argument in heard if number in MOVING} == {0}
    assert heard[0][0] == Command.STOP
    assert robot.body.odometry == before


def press(robot: SimulatedPioneer) -> None:
    robot.firmware.e_stop_pressed = True


def drain(robot: SimulatedPioneer) -> None:
    robot.firmware.reports.battery_dv = 108


def run_low(robot: SimulatedPioneer) -> None:
    robot.firmware.reports.battery_dv = 113


@pytest.mark.parametrize(
    ("happens", "state", "text", "cure"),
    [
        (press, "failed", "the emergency stop is pressed", "mend that"),
        (drain, "failed", "the battery is empty: 10.8 V", "mend that"),
        (run_low, "warning", "the battery is low: 11.3 V", "charge it"),
    ],
)
def test_what_is_in_the_way_of_driving_is_said(look: Any, happens: Any, state: str, text: str, cure: str) -> None:
    robot = SimulatedPioneer()
    happens(robot)
    finding = look(check_robot, robot)
    assert told([finding]) == [f"{state} robot"]
    assert text in finding.text
    assert finding.cure.startswith(cure)


def test_a_robot_whose_counts_nobody_knows_is_refused_with_the_key_that_says_them(look: Any) -> None:
    finding = look(check_robot, SimulatedPioneer(Character("p9", 1.0)))
    assert told([finding]) == ["failed robot"]
    assert "distance_factor_mm" in finding.text
    assert "[robot]" in finding.cure


def test_a_robot_of_which_reports_are_lost_is_noticed(look: Any) -> None:
    robot = SimulatedPioneer()
    faulty = FaultyWire(robot, SIP, parse_fault("robot=slow:2@1"), np.random.default_rng(1), START_NS)
    finding = look(check_robot, faulty)
    assert told([finding]) == ["failed robot"]
    assert "expected 10 reports a second, got " in finding.text


def test_noise_on_a_robots_line_is_warned_of(look: Any) -> None:
    robot = FaultyWire(SimulatedPioneer(), SIP, parse_fault("robot=garbage:0.01@1"), np.random.default_rng(1), START_NS)
    finding = look(check_robot, robot)
    assert told([finding]) == ["warning robot"]
    assert "bytes a second of noise on its line" in finding.text


def test_a_laser_that_is_well_is_named_with_its_rate(look: Any) -> None:
    finding = look(check_laser, scanner())
    assert told([finding]) == ["ok laser"]
    assert finding.text.startswith("LMS200;301063;V02.10, 38400 baud, 5.")
    assert "of 361 beams, nearest 2.9" in finding.text


def test_the_memory_of_a_laser_is_not_written_even_where_that_is_configured(look: Any) -> None:
    device = scanner()
    finding = look(check_laser, device, laser={"measuring_mode": 2, "write_eeprom": True})
    assert told([finding]) == ["warning laser"]
    assert "measuring mode 0 instead of 2" in finding.text
    assert "write_eeprom = true once" in finding.cure
    assert device.settings.written == 0


def cover(device: LmsScanner) -> None:
    device.covered = True


def pollute(device: LmsScanner) -> None:
    device.status_byte = 0x90


@pytest.mark.parametrize(
    ("happens", "state", "text"),
    [(cover, "failed", "covered or dazzled"), (pollute, "warning", "front window polluted")],
)
def test_a_laser_that_does_not_see_well_says_why(look: Any, happens: Any, state: str, text: str) -> None:
    device = scanner()
    happens(device)
    finding = look(check_laser, device)
    assert told([finding]) == [f"{state} laser"]
    assert text in finding.text
    assert "its window" in finding.cure


def test_a_laser_on_a_noisy_line_is_noticed(look: Any) -> None:
    device = scanner()
    faulty = FaultyWire(device, LMS, parse_fault("laser=garbage:0.0005@1"), np.random.default_rng(1), START_NS)
    assert told([look(check_laser, faulty)]) == ["failed laser"]


def test_scans_that_are_not_driven_by_long_enough_are_warned_of(look: Any) -> None:
    finding = look(check_laser, scanner(), safety={"max_scan_age_s": 0.5})
    assert told([finding]) == ["warning laser"]
    assert "expected scans driven by until they are 0.7" in finding.text


def test_swapped_ports_are_noticed_by_both_and_say_so(look: Any) -> None:
    for check, device in ((check_robot, scanner()), (check_laser, SimulatedPioneer())):
        finding = look(check, device)
        assert finding.state.value == "failed"
        assert "got no answer" in finding.text
        assert "swapped" in finding.cure


def test_a_device_that_another_holds_is_told_with_its_name_without_the_check_of_ports(
    look: Any, tmp_path: Path
) -> None:
    for check, device, port in (
        (check_robot, SimulatedPioneer(), "/dev/robot"),
        (check_laser, scanner(), "/dev/laser"),
    ):
        lock = PortLock(port, "edgefusion base", tmp_path)
        lock.acquire()
        finding = look(check, device)
        lock.release()
        assert finding.state.value == "failed"
        assert "it is held by edgefusion base" in finding.text
        assert "end that process" in finding.cure


def test_what_cannot_be_asked_is_skipped_with_the_reason(tmp_path: Path) -> None:
    exam = examination(tmp_path)
    exam.unusable |= {exam.config.robot.port, exam.config.laser.port}
    elsewhere = examination(tmp_path, service={"processes": ("bus", "vision")})
    for check in (check_robot, check_laser):
        assert [each.text for each in check(exam)] == ["its port cannot be used"]
        assert [each.text for each in check(elsewhere)] == ["base runs on another machine"]
