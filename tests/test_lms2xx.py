# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The LMS2xx's driver against a scripted scanner on a pty, from whatever state a crash left it in."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from edgefusion.config import LaserConfig
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.drivers.lms2xx_line import LaserError
from edgefusion.drivers.lms2xx_telegram import encode
from edgefusion.drivers.lms2xx_timing import TURN_NS, line_ns, mean_wait_ns
from edgefusion.errors import RefusedError
from edgefusion.types import HealthState, Scan
from scripted_lms2xx import ScriptedLms2xx

EEPROM = 0x77


class Session:
    """A driver on a scripted scanner; pauses take no time and are written down."""

    def __init__(self, laser: ScriptedLms2xx, folder: Path, config: LaserConfig, answer_s: float = 0.2) -> None:
        self.pauses: list[float] = []
        self.link = Link(laser.port, 9600, lock_folder=folder)
        self.driver = Lms2xx(self.link, config, pause=self.pauses.append, answer_s=answer_s)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.driver.close()

    def scan(self) -> Scan:
        for _ in range(1000):
            scans = self.driver.read()
            if scans:
                return scans[0]
        raise AssertionError("no scan came")


@pytest.mark.parametrize("wanted", [38400, 500000])
@pytest.mark.parametrize("left_at", [9600, 19200, 38400, 500000])
def test_it_finds_the_speed_and_stops_what_a_crashed_run_left(tmp_path: Path, left_at: int, wanted: int) -> None:
    with ScriptedLms2xx(left_at, b"\x24") as laser, Session(laser, tmp_path, LaserConfig(baudrate=wanted)) as session:
        session.driver.start()
        assert laser.baud == session.link.baudrate == wanted
        scan = session.scan()
        assert len(scan.ranges_m) == 361
        assert scan.ranges_m == pytest.approx(2.0)
        assert session.driver.health.state is HealthState.OK


def test_closing_stops_the_stream_and_goes_back_to_the_speed_after_power_on(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser:
        with Session(laser, tmp_path, LaserConfig()) as session:
            session.driver.start()
            session.scan()
        assert (laser.baud, laser.streaming) == (9600, b"")
        assert session.driver.health.state is HealthState.STARTING


def test_a_scan_is_stamped_when_its_middle_beam_was_measured(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig()) as session:
        session.driver.start()
        before_ns = time.monotonic_ns()
        scan = session.scan()
        while scan.stamp_ns + line_ns(732, 38400) < before_ns:  # what had come before
            scan = session.scan()
        after_ns = time.monotonic_ns()
        assert scan.beam_dt_ns is not None
        older_ns = line_ns(732, 38400) + mean_wait_ns(732, 2, 38400) + int(scan.beam_dt_ns.max())
        assert before_ns <= scan.stamp_ns + older_ns <= after_ns
        assert scan.beam_dt_ns.max() == pytest.approx(TURN_NS * 1.25, rel=0.01)


def test_partial_scans_come_a_turn_at_a_time(tmp_path: Path) -> None:
    config = LaserConfig(baudrate=500000, partial_scans=True)
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, config) as session:
        session.driver.start()
        scan = session.scan()
        assert len(scan.ranges_m) == 181
        assert np.degrees(scan.angle_increment) == pytest.approx(1)


@pytest.mark.parametrize(("mode", "unit"), [(0, 1), (3, 1), (5, 0)])
def test_the_memory_is_not_written_unless_allowed(tmp_path: Path, mode: int, unit: int) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig(baudrate=38400)) as session:
        laser.block[5:7] = [mode, unit]
        session.driver.start()
        scan = session.scan()
        assert not any(command[0] == EEPROM for command in laser.commands)
        assert scan.ranges_m == pytest.approx(2.0 if unit else 20.0)
        assert scan.range_max_m == pytest.approx({0: 8.183, 3: 16.375, 5: 327.59}[mode])
        reason = session.driver.health.reason
        assert ("measuring mode" in reason, "unit cm instead of mm" in reason) == (mode != 0, unit == 0)


@pytest.mark.parametrize(("mode", "unit", "writes"), [(0, 1, 0), (3, 1, 1), (0, 0, 1)])
def test_the_memory_is_written_once_only_where_it_differs(tmp_path: Path, mode: int, unit: int, writes: int) -> None:
    config = LaserConfig(write_eeprom=True)
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, config) as session:
        laser.block[5:7] = [mode, unit]
        others = bytes(laser.block[:5] + laser.block[7:])
        session.driver.start()
        session.driver.start()
        assert sum(command[0] == EEPROM for command in laser.commands) == writes
        assert list(laser.block[5:7]) == [0, 1]
        assert bytes(laser.block[:5] + laser.block[7:]) == others
        session.scan()
        assert session.driver.health.state is HealthState.OK


def test_an_angle_and_resolution_that_it_has_are_not_sent_again(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig(beams=401)) as session:
        session.driver.start()
        session.driver.start()
        assert sum(command[0] == 0x3B for command in laser.commands) == 1
        assert laser.variant == (100, 25)


def test_a_nak_is_answered_by_the_same_command(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig()) as session:
        laser.naks = 1
        session.driver.start()
        assert laser.commands[:2] == [b"\x20\x25", b"\x20\x25"]


def test_a_refused_command_is_said(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig()) as session:
        laser.refused = {b"\x20\x24"}
        with pytest.raises(LaserError, match="refused the command that a0 answers"):
            session.driver.start()
        assert session.driver.health.state is HealthState.FAILED


def test_no_scanner_at_any_speed_is_said(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig(), answer_s=0.001) as session:
        laser.naks = 1000
        with pytest.raises(LaserError, match="expected an LMS2xx, got no answer at any of 9600, 38400, 500000, 19200"):
            session.driver.start()
        assert "no answer" in session.driver.health.reason


def test_a_measuring_mode_without_ranges_is_refused(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig()) as session:
        laser.block[5] = 0x3F
        with pytest.raises(RefusedError, match="measuring mode: expected 0 to 6, got 63"):
            session.driver.start()


def test_pollution_is_health_and_its_scans_are_kept(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig()) as session:
        laser.type_6 = 0x92
        session.driver.start()
        assert session.scan().ranges_m == pytest.approx(2.0)
        assert session.driver.health.state is HealthState.DEGRADED
        assert session.driver.health.reason == "reports: warning, front window polluted"


def test_a_scanner_that_starts_anew_must_be_started_anew(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig()) as session:
        session.driver.start()
        session.scan()
        laser.say = [encode(b"\x90LMS200;30106;V02.10 \x10", 0x81)]
        with pytest.raises(LaserError, match="the scanner started anew: LMS200;30106"):
            for _ in range(1000):
                session.driver.read()
        with pytest.raises(LaserError, match=r"expected start\(\) before read\(\)"):
            session.driver.read()
        session.driver.start()
        session.scan()


def test_only_at_500000_baud_the_bytes_keep_apart(tmp_path: Path) -> None:
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig(baudrate=500000)) as session:
        session.driver.start()
        assert session.pauses.count(60e-6) >= len(encode(b"\x20\x24"))
        assert 0.25 in session.pauses
    with ScriptedLms2xx() as laser, Session(laser, tmp_path, LaserConfig()) as session:
        session.driver.start()
        assert 60e-6 not in session.pauses


def test_a_line_that_vanishes_is_a_failure(tmp_path: Path) -> None:
    with Session(ScriptedLms2xxGone(), tmp_path, LaserConfig()) as session:
        with pytest.raises(LinkError, match="cannot be opened"):
            session.driver.start()
        assert session.driver.health.state is HealthState.FAILED


class ScriptedLms2xxGone(ScriptedLms2xx):
    port = "/dev/no-such-laser"


def test_partial_scans_need_the_fast_line() -> None:
    with pytest.raises(RefusedError, match="partial_scans: expected a baudrate of 500000 with them, got 38400"):
        LaserConfig(partial_scans=True)
