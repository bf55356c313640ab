# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Vision on another computer than the robot's: it reckons with the robot's clock, or not at all."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import msgspec
import numpy as np
import pytest

from bus_lab import Lab, make_keys, until
from edgefusion.bus.clock_id import clock_id
from edgefusion.bus.clock_reading import ClockTeller, Reading, read_clock
from edgefusion.bus.latest import Latest
from edgefusion.bus.topics import DETECTIONS_DETAIL
from edgefusion.clock import SimClock, system_clock
from edgefusion.config import Config
from edgefusion.messages.from_odometry import from_odometry
from edgefusion.messages.from_scan import from_scan
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.perception.calibration import load_calibration
from edgefusion.service.robot_camera import RobotCamera
from edgefusion.service.robot_clock import RobotClock
from edgefusion.service.robot_time import robot_time
from edgefusion.service.vision import Vision
from edgefusion.types import Frame, Pose2D, Scan, Twist2D
from scene import write_recording
from vision_lab import ODOM, SCAN, STAMPER, FakeBase, PaintedCamera
from vision_scenes import MS, ToldDetector

S = 1_000_000_000
AHEAD_NS = 1000 * S
"""The robot was started before the other computer."""


def robots_clock() -> int:
    return system_clock() + AHEAD_NS


def test_another_computers_clock_is_read_with_no_more_than_the_error_that_is_said(lab: Lab) -> None:
    teller = ClockTeller(lab.member(), "robot", "the robot's", robots_clock)
    laptop = lab.member()
    readings: list[Reading] = []
    until(lambda: readings.append(read_clock(laptop, "robot", 1.0)) or readings[-1])
    assert readings[-1].clock == "the robot's"
    assert abs(readings[-1].ahead_ns - AHEAD_NS) <= readings[-1].error_ns < S
    teller.undeclare()


def test_where_nobody_tells_a_clock_there_is_none(lab: Lab) -> None:
    assert read_clock(lab.member(), "robot", 0.1) is None


def test_with_keys_the_clock_is_for_the_robots_own_processes_alone(tmp_path) -> None:
    with ExitStack() as stack:
        lab = Lab(stack, make_keys(tmp_path))
        lab.router()
        teller = ClockTeller(lab.member(), "robot", "the robot's", robots_clock)
        until(lambda: read_clock(lab.client("robot"), "robot", 0.5))
        assert read_clock(lab.client("operator"), "robot", 0.2) is None
        teller.undeclare()


def test_of_the_newest_readings_the_most_exact_one_counts() -> None:
    own = SimClock(10 * S)
    clock = RobotClock("own", own)
    assert (clock(), clock.id) == (10 * S, "own")
    clock.read(Reading("theirs", 5 * S + 9, 100))
    clock.read(Reading("theirs", 5 * S + 1, 10))
    clock.read(Reading("theirs", 5 * S + 7, 80))
    assert (clock() - 15 * S, clock.error_ns, clock.id) == (1, 10, "theirs")
    assert clock.own(clock.of(123)) == 123
    for _ in range(8):  # they drift apart, and it is not exact for ever
        clock.read(Reading("theirs", 5 * S + 50, 40))
    assert (clock() - 15 * S, clock.error_ns) == (50, 40)


def test_a_reading_of_this_computers_own_clock_changes_nothing() -> None:
    clock = RobotClock("own", SimClock(10 * S))
    clock.read(Reading("own", 30, 40))
    assert (clock(), clock.error_ns) == (10 * S, 0)


def test_a_robot_that_was_started_anew_is_noticed() -> None:
    clock = RobotClock("own", SimClock(1))
    clock.read(Reading("theirs", 5, 1))
    with pytest.raises(RuntimeError, match="expected theirs, got another: it began anew"):
        clock.read(Reading("another", 5, 1))


class TwoFrames(PaintedCamera):
    """Of one computer's clock."""

    def after(self, stamp_ns: int) -> list[Frame]:
        frames = [Frame(ns, np.zeros((2, 2, 3), np.uint8)) for ns in (5 * S, 6 * S)]
        return [frame for frame in frames if frame.stamp_ns > stamp_ns]


def test_a_frame_keeps_its_stamp_when_the_clock_is_known_better_and_is_seen_once() -> None:
    clock = RobotClock("own", SimClock(6 * S))
    clock.read(Reading("theirs", AHEAD_NS, 10 * MS))
    camera = RobotCamera(TwoFrames(), clock)
    assert [frame.stamp_ns - AHEAD_NS for frame in camera.after(AHEAD_NS)] == [5 * S, 6 * S]
    clock.read(Reading("theirs", AHEAD_NS + 9 * MS, MS))
    assert camera.after(6 * S + AHEAD_NS) == []
    assert [frame.stamp_ns - AHEAD_NS for frame in camera.after(5 * S + AHEAD_NS)] == [6 * S]


class RobotsBase(FakeBase):
    """On the robot's computer."""

    def speak(self) -> None:
        now_ns = robots_clock()
        if now_ns < self._due_ns:
            return
        self._due_ns, stamp_ns = now_ns + 100 * MS, now_ns - 10 * MS
        scan = Scan(stamp_ns, self.scan.ranges_m, self.scan.angle_min, self.scan.angle_increment)
        self.put(ODOM, from_odometry(stamp_ns, Pose2D(), Twist2D(), STAMPER), stamp_ns)
        self.put(SCAN, from_scan(scan, STAMPER), stamp_ns)


def test_what_vision_sees_on_another_computer_is_stamped_by_the_robots_clock(lab: Lab, tmp_path) -> None:
    base = RobotsBase(lab)
    base.clock = "the robot's"
    teller = ClockTeller(lab.member(), "robot", base.clock, robots_clock)
    bus = msgspec.structs.replace(lab.config, connect=lab.tcp)
    calibration = load_calibration(write_recording(tmp_path / "drive") / "calibration.toml")
    heard: Latest[Any] = Latest(lab.client(), "robot", DETECTIONS_DETAIL, to_detections_detail, robots_clock)
    with robot_time(bus, clock_id()) as known:
        until(known)
        clock = known()
        vision = Vision(
            Config(bus=bus),
            calibration,
            ToldDetector(),
            lambda: "",
            RobotCamera(PaintedCamera(), clock),
            STAMPER,
            clock,
            clock.id,
        )
        vision.begin()

        def seen() -> bool:
            base.speak()
            vision.turn()
            return heard.value is not None

        until(seen, 20.0)
        vision.end()
    assert -5 * S < heard.value.stamp_ns - robots_clock() < 0
    teller.undeclare()


def test_on_the_robots_computer_its_clock_is_known_at_once_and_is_this_one(lab: Lab) -> None:
    with robot_time(lab.config) as known:
        clock = known()
        assert clock is not None
        assert (clock.id, clock.ahead_ns) == (clock_id(), 0)
