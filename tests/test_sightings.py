# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Detections of several frames become sightings, wherever the robot drove in between."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.tools.sightings import CONFIRMED_FRAMES, SAME_PLACE_M, Sightings
from edgefusion.types import ClassScore, Cluster, Detection, Pose2D, Vote

CLASS = ClassScore(0, "oscilloscope", 0.9)
HERE = Pose2D()
DETECTION = Detection(
    stamp_ns=0, class_index=0, label="oscilloscope", group="", score=0.9, margin=0.8, box=(1, 2, 3, 4),
    distance_m=2.0, distance_sigma_m=0.01, bearing=0.0, position_m=(2.0, 0.0), vote=Vote((CLASS,), 0, 0.8, ((CLASS,),)),
    boxes=((1, 2, 3, 4),), cluster=Cluster(np.arange(3), 2.0, 0.0, 0.3), scan_frame_dt_ns=0,
)  # fmt: skip
POSES = st.builds(Pose2D, st.floats(-9, 9), st.floats(-9, 9), st.floats(-math.pi, math.pi))


def seen(x_m: float, y_m: float, pose: Pose2D = HERE, label: str = "oscilloscope") -> Detection:
    """What stands at a point of the world, seen from a pose."""
    there = Pose2D(x_m, y_m).relative_to(pose)
    return replace(DETECTION, label=label, position_m=(there.x_m, there.y_m))


def test_what_is_seen_in_three_frames_is_confirmed_once_by_the_third() -> None:
    sightings = Sightings()
    answers = [sightings.add(frame, HERE, [seen(2, 0)]) for frame in range(CONFIRMED_FRAMES + 2)]
    assert [len(each) for each in answers] == [0, 0, 1, 0, 0]
    (sighting,) = sightings.confirmed
    assert (sighting.label, sighting.count) == ("oscilloscope", CONFIRMED_FRAMES + 2)
    assert sighting.first is sighting.detections[CONFIRMED_FRAMES - 1]


def test_two_detections_of_one_frame_count_as_one() -> None:
    sightings = Sightings()
    for frame in range(2):
        assert sightings.add(frame, HERE, [seen(2, 0), seen(2, 0.3), seen(2, 0.1)]) == []
    assert sightings.confirmed == []


@given(poses=st.lists(POSES, min_size=3, max_size=6))
def test_one_thing_is_one_sighting_from_wherever_it_is_seen(poses: list[Pose2D]) -> None:
    sightings = Sightings()
    for frame, pose in enumerate(poses):
        sightings.add(frame, pose, [seen(3, -1, pose)])
    (sighting,) = sightings.confirmed
    assert sighting.place_m == pytest.approx((3, -1))
    assert sighting.count == len(poses)


@pytest.mark.parametrize(
    "other",
    [seen(2, SAME_PLACE_M + 0.01), seen(2, 0, label="speaker")],
    ids=["another place", "another label"],
)
def test_another_place_or_label_is_another_sighting(other: Detection) -> None:
    sightings = Sightings()
    for frame in range(CONFIRMED_FRAMES):
        sightings.add(frame, HERE, [seen(2, 0), other])
    assert [each.count for each in sightings.confirmed] == [CONFIRMED_FRAMES, CONFIRMED_FRAMES]


def test_a_thing_whose_nearest_point_wanders_stays_one_sighting() -> None:
    """A desk is 1.6 m long; the robot drives along it."""
    sightings = Sightings()
    for frame in range(9):
        sightings.add(frame, HERE, [seen(2, 0.2 * frame)])
    (sighting,) = sightings.confirmed
    assert sighting.count == 9
    assert sighting.place_m == pytest.approx((2, 0.8))
