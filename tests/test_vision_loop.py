# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What vision looks at: pairs of one moment, the newest of them, and nothing of a camera that does not see."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camera_scenes import flat, scene
from edgefusion.config import CameraConfig
from edgefusion.messages.to_odometry import Reckoning
from edgefusion.types import STILL, Pose2D, Twist2D
from vision_scenes import MS, Bench, scan

PATIENT = CameraConfig(lost_s=5.0, read_timeout_s=9.0, frozen_s=9.0)
FORWARD = Twist2D(0.5, 0.0)


def test_every_scan_is_looked_at_with_the_frame_of_its_moment() -> None:
    looks = Bench().look_for(2000)
    assert len(looks) >= 23  # of 25 scans; the last may wait for its frame
    assert all(look.scan.stamp_ns == look.frame.stamp_ns for look in looks)


@settings(max_examples=30)
@given(skew_ms=st.integers(0, 500))
def test_what_is_further_apart_than_the_tolerance_is_never_looked_at_and_the_rest_always(skew_ms: int) -> None:
    bench, looks = Bench(PATIENT), []
    for number in range(6):
        frame_ns = bench.clock.advance(1100 * MS)
        bench.camera.show(scene(number))
        looks.append(bench.loop.step([scan(frame_ns - skew_ms * MS)]))
    seen = [look for look in looks if look is not None]
    assert len(seen) >= 5 if skew_ms <= 100 else not seen
    assert all(look.frame.stamp_ns - look.scan.stamp_ns == skew_ms * MS for look in seen)


@pytest.mark.parametrize("latency_ms", [200, 1000])
def test_a_slow_detector_gets_the_newest_pair_and_what_it_missed_is_counted(latency_ms: int) -> None:
    bench = Bench()
    bench.detector.meanwhile = lambda: bench.pass_ms(latency_ms)
    looks = bench.look_for(20_000)
    assert len(looks) >= 0.9 * 20_000 / (latency_ms + 85)
    assert all(look.age_ns <= 2 * latency_ms * MS for look in looks)
    assert bench.loop.overtaken > len(looks) / 2


def test_of_an_unplugged_camera_nothing_is_seen_from_a_fifth_of_a_second_on_until_it_is_back() -> None:
    bench = Bench()
    bench.look_for(1000)
    last_ns = bench.clock()
    bench.shows = lambda _: None
    assert all(look.begun_ns - last_ns <= 200 * MS for look in bench.look_for(400))
    bench.pass_ms(50)
    assert bench.turn() is None
    assert bench.loop.trouble.startswith("CAMERA_LOST")
    assert not bench.look_for(2000)
    bench.shows = scene
    assert bench.look_for(1000)
    assert bench.loop.trouble == ""


@pytest.mark.parametrize(
    ("picture", "reason"), [(scene(7), "CAMERA_FROZEN"), (flat(0), "CAMERA_BLIND"), (flat(255), "CAMERA_BLIND")]
)
def test_a_camera_that_shows_nothing_is_named_within_a_second_and_nothing_is_seen_after(
    picture: np.ndarray, reason: str
) -> None:
    bench = Bench()
    bench.look_for(1000)
    bench.shows = lambda _: picture
    bench.look_for(1000)
    assert bench.loop.trouble.startswith(reason)
    assert not bench.look_for(3000)


@pytest.mark.parametrize("level", [0, 255])
def test_a_black_or_white_picture_is_never_looked_at(level: int) -> None:
    bench = Bench()
    bench.look_for(1000)
    begun_ns, bench.shows = bench.clock(), lambda _: flat(level)
    assert all(look.frame.stamp_ns <= begun_ns for look in bench.look_for(400))
    assert bench.loop.trouble == ""


def test_what_the_detector_finds_in_a_frame_is_nothing_when_the_camera_is_lost_meanwhile() -> None:
    bench = Bench()
    bench.look_for(500)

    def lose() -> None:
        bench.shows = lambda _: None
        bench.pass_ms(300)

    bench.detector.meanwhile, before = lose, len(bench.detector.frames)
    assert not bench.look_for(1000)
    assert len(bench.detector.frames) == before + 1


def test_the_motion_between_scan_and_frame_is_that_of_the_odometry() -> None:
    bench = Bench(frame_ms=40, scan_ms=80, late_ms=20)
    start_ns = bench.clock()
    bench.odometry.report("run", Reckoning(start_ns, Pose2D(), FORWARD))
    for number in range(1, 30):
        now_ns = bench.clock.advance(40 * MS)
        bench.odometry.report("run", Reckoning(now_ns, Pose2D(0.5 * (now_ns - start_ns) / 1e9), FORWARD))
        bench.camera.show(scene(number))
        bench.loop.step([scan(now_ns - 10 * MS)])
    assert len(bench.detector.motions) > 20
    for motion in bench.detector.motions:
        assert motion.x_m == pytest.approx(0.5 * 0.010, abs=1e-9)


def test_a_base_that_was_started_anew_moves_nothing_by_where_it_begins_to_count() -> None:
    bench = Bench()
    for run, x_m in (("first", 7.0), ("second", 0.0)):
        for _ in range(20):
            bench.odometry.report(run, Reckoning(bench.clock(), Pose2D(x_m), Twist2D()))
            bench.look_for(40)
    assert len(bench.detector.motions) > 10
    assert all(motion == STILL for motion in bench.detector.motions)


def test_without_odometry_the_pose_is_none_and_the_robot_is_taken_to_stand() -> None:
    bench = Bench()
    assert {look.pose for look in bench.look_for(500)} == {None}
    assert set(bench.detector.motions) == {STILL}


def test_a_frame_that_the_detector_refuses_is_told_and_ends_nothing() -> None:
    bench = Bench()

    def refuse() -> None:
        raise ValueError("image: the calibration expects 640x480, got 160x120")

    bench.detector.meanwhile = refuse
    assert not bench.look_for(500)
    assert "640x480, got 160x120" in bench.loop.trouble
    bench.detector.meanwhile = lambda: None
    assert bench.look_for(500)
    assert bench.loop.trouble == ""
