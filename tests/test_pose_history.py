# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The pose history answers for the time that it covers, and for no other."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.pose_history import PoseHistory
from edgefusion.types import Pose2D


def history(*entries: tuple[int, Pose2D], span_ns: int = 100) -> PoseHistory:
    poses = PoseHistory(span_ns)
    for stamp_ns, pose in entries:
        poses.add(stamp_ns, pose)
    return poses


def test_between_two_stamps_the_pose_is_between_the_poses() -> None:
    poses = history((10, Pose2D(0, 0, 0)), (20, Pose2D(1, 2, 0.4)))
    assert poses.at(10) == Pose2D(0, 0, 0)
    assert poses.at(20) == Pose2D(1, 2, 0.4)
    middle = poses.at(15)
    assert (middle.x_m, middle.y_m, middle.theta) == pytest.approx((0.5, 1, 0.2))


def test_it_turns_the_short_way() -> None:
    middle = history((0, Pose2D(0, 0, 3.0)), (2, Pose2D(0, 0, -3.0))).at(1)
    assert abs(middle.theta) == pytest.approx(math.pi)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=40), st.integers(1, 200))
def test_it_covers_the_span_and_forgets_what_is_older(steps_ns: list[int], span_ns: int) -> None:
    stamps_ns = [sum(steps_ns[:i]) for i in range(len(steps_ns) + 1)]
    poses = history(*((stamp_ns, Pose2D(stamp_ns)) for stamp_ns in stamps_ns), span_ns=span_ns)
    oldest_ns = max([stamp_ns for stamp_ns in stamps_ns if stamp_ns <= stamps_ns[-1] - span_ns], default=0)
    for stamp_ns in range(oldest_ns, stamps_ns[-1] + 1):
        assert poses.at(stamp_ns).x_m == pytest.approx(stamp_ns)
    for outside_ns in (oldest_ns - 1, stamps_ns[-1] + 1):
        with pytest.raises(RefusedError, match=f"^stamp_ns: the poses cover {oldest_ns} to {stamps_ns[-1]}, got"):
            poses.at(outside_ns)


def test_nothing_is_known_before_the_first_pose() -> None:
    with pytest.raises(RefusedError, match=r"^stamp_ns: the poses cover no time yet, got 5$"):
        PoseHistory().at(5)


@pytest.mark.parametrize("stamp_ns", [9, 10])
def test_stamps_rise(stamp_ns: int) -> None:
    with pytest.raises(RefusedError, match=f"^stamp_ns: expected more than 10, got {stamp_ns}$"):
        history((10, Pose2D()), (stamp_ns, Pose2D()))
