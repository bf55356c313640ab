# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Sightings become objects: confirmed by several frames, in whatever order they arrive, and never two for one."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.config import MissionConfig
from edgefusion.navigation.mission import Mission
from edgefusion.navigation.objects import KnownObject, KnownObjects
from edgefusion.types import Goal, Pose2D
from mission_scenes import DETECTION, TICK_NS, OpenGround, Thing, seen

SETTINGS = MissionConfig()
MS = 1_000_000
RADIUS_M = 0.49 * SETTINGS.same_place_m
THINGS = [Thing(2.0, 0.0), Thing(2.0, 1.5), Thing(2.0, -1.5, "minivan", "car"), Thing(2.0, -1.6, "oscilloscope")]
SCATTER = st.tuples(st.floats(0, RADIUS_M), st.floats(-math.pi, math.pi))
SIGHTINGS = st.lists(st.tuples(st.sampled_from(range(len(THINGS))), st.integers(0, 3000), SCATTER), max_size=40)


def sight(objects: KnownObjects, stamp_ms: int, x_m: float = 2.0, y_m: float = 0.0, label: str = "oscilloscope"):
    return objects.add(replace(DETECTION, stamp_ns=stamp_ms * MS, label=label), (x_m, y_m))


def scattered(thing: Thing, scatter: tuple[float, float]) -> tuple[float, float]:
    off_m, direction = scatter
    return thing.x_m + off_m * math.cos(direction), thing.y_m + off_m * math.sin(direction)


def test_the_third_frame_confirms_and_a_second_detection_of_a_frame_does_not() -> None:
    objects = KnownObjects(SETTINGS)
    answers = [sight(objects, stamp_ms).confirmed for stamp_ms in (0, 0, 200, 200, 400, 600)]
    assert answers == [False, False, False, False, True, True]


@pytest.mark.parametrize(("last_ms", "confirmed"), [(2000, True), (2001, False)])
def test_frames_confirm_within_the_window_alone(last_ms: int, confirmed: bool) -> None:
    objects = KnownObjects(SETTINGS)
    for stamp_ms in (0, 500):
        sight(objects, stamp_ms)
    assert sight(objects, last_ms).confirmed == confirmed


@pytest.mark.parametrize("order", list(itertools.permutations((0, 500, 2000, 2600))))
def test_frames_confirm_in_whatever_order_they_arrive(order: tuple[int, ...]) -> None:
    objects = KnownObjects(SETTINGS)
    assert [sight(objects, stamp_ms) for stamp_ms in order][-1].confirmed


@given(stamps_ms=st.lists(st.integers(0, 5000), min_size=1, max_size=8, unique=True), data=st.data())
def test_what_is_confirmed_in_one_order_is_confirmed_in_any(stamps_ms: list[int], data: st.DataObject) -> None:
    in_order, shuffled = KnownObjects(SETTINGS), KnownObjects(SETTINGS)
    for stamp_ms in sorted(stamps_ms):
        first = sight(in_order, stamp_ms)
    for stamp_ms in data.draw(st.permutations(stamps_ms)):
        second = sight(shuffled, stamp_ms)
    assert first.confirmed == second.confirmed


def test_sightings_that_disagree_in_place_confirm_nothing() -> None:
    objects = KnownObjects(SETTINGS)
    assert not any(sight(objects, 200 * i, y_m=0.7 * i).confirmed for i in range(5))


def test_the_place_of_a_known_object_is_refined_by_further_sightings() -> None:
    objects = KnownObjects(SETTINGS)
    first = sight(objects, 0, y_m=0.2)
    assert first.place_m == (2.0, 0.2)
    for i in range(1, 10):
        sight(objects, 200 * i, y_m=0.0)
    assert first.place_m == pytest.approx((2.0, 0.02))


def test_a_place_follows_the_odometry_when_it_has_drifted() -> None:
    objects = KnownObjects(SETTINGS)
    for i in range(1000):
        found = sight(objects, 200 * i, y_m=0.0)
    for i in range(100):
        found = sight(objects, 200 * (1000 + i), y_m=0.3)
    assert len(objects) == 1
    assert found.place_m == pytest.approx((2.0, 0.3), abs=0.01)


def test_objects_whose_places_turn_out_to_be_one_become_the_first_of_them() -> None:
    objects = KnownObjects(SETTINGS)
    first, second = sight(objects, 0, y_m=0.0), sight(objects, 200, y_m=0.65)
    first.visited = True
    assert len(objects) == 2
    found = sight(objects, 400, y_m=0.4)
    assert found is first
    assert len(objects) == 1
    assert found.confirmed and found.visited
    assert found.place_m == pytest.approx((2.0, 1.05 / 3))
    assert second is not found


def test_what_was_known_of_either_is_known_of_both_when_they_become_one() -> None:
    objects = KnownObjects(SETTINGS)
    first = sight(objects, 10_000, y_m=0.0)
    for stamp_ms in (0, 200, 400):
        second = sight(objects, stamp_ms, y_m=0.65)
    second.due = second.visited = True
    assert not first.confirmed
    assert sight(objects, 600, y_m=0.4) is first
    assert first.confirmed and first.due and first.visited


def test_the_best_of_its_sightings_stands_for_an_object() -> None:
    objects = KnownObjects(SETTINGS)
    for i, score in enumerate((0.5, 0.8, 0.6)):
        found = objects.add(replace(DETECTION, stamp_ns=i, score=score), (2.0, 0.0))
    assert found.best.score == 0.8


def test_another_label_in_the_same_place_is_another_object() -> None:
    objects = KnownObjects(SETTINGS)
    sight(objects, 0)
    sight(objects, 0, label="joystick")
    assert len(objects) == 2


def test_what_was_sighted_too_seldom_is_forgotten_and_what_is_confirmed_is_not() -> None:
    objects = KnownObjects(SETTINGS)
    for stamp_ms in (0, 200, 400):
        sight(objects, stamp_ms)
    sight(objects, 400, y_m=3.0)
    objects.forget_unconfirmed(401 * MS)
    assert len(objects) == 1
    assert objects.at("oscilloscope", (2.0, 0.0)) is not None


def test_the_nearest_object_that_is_due_is_next() -> None:
    objects = KnownObjects(SETTINGS)
    far, near, here = (sight(objects, 0, x_m=x_m) for x_m in (4.0, 2.0, 0.5))
    assert objects.next_due((0.0, 0.0)) is None
    far.due = near.due = here.due = here.visited = True
    assert objects.next_due((0.0, 0.0)) is near


@given(sightings=SIGHTINGS)
def test_one_thing_is_one_object_however_its_sightings_scatter_within_the_radius(sightings) -> None:
    objects = KnownObjects(SETTINGS)
    found: dict[int, set[KnownObject]] = {}
    for which, stamp_ms, scatter in sightings:
        thing = THINGS[which]
        detection = replace(DETECTION, stamp_ns=stamp_ms * MS, label=thing.label, group=thing.group)
        found.setdefault(which, set()).add(objects.add(detection, scattered(thing, scatter)))
    assert all(len(each) == 1 for each in found.values())
    assert len(objects) == len(found)


@settings(max_examples=30)
@given(
    frames=st.lists(
        st.tuples(st.integers(0, 60), st.integers(0, 20), st.sampled_from(range(len(THINGS))), SCATTER), max_size=60
    )
)
def test_no_sequence_of_detections_leads_to_two_inspections_of_one_thing(frames) -> None:
    """frames: (step of arrival, how many steps ago it was seen, thing, scatter): late, in disorder, repeated."""
    hasty = MissionConfig(
        interest=("oscilloscope", "car"), stand_s=0.1, picture_s=0.1, facing_s=0.1, last_look_s=0.0, confirm_frames=2
    )
    mission = Mission(hasty, OpenGround(jams=lambda goal: "facing" in goal.id, stiff=lambda goal: True))
    mission.goto([Goal("never", Pose2D(9, 9))])
    inspected = []
    for step in range(120):
        arriving = [frame for frame in frames if frame[0] == step]
        detections = []
        for _, ago, which, scatter in arriving:
            x_m, y_m = scattered(THINGS[which], scatter)
            thing = THINGS[which]._replace(x_m=x_m, y_m=y_m)
            detections.append(seen(thing, Pose2D(), max(step - ago, 0) * TICK_NS))
        result = mission.step(step * TICK_NS, None, Pose2D(), detections).result
        if result is not None:
            inspected.append(min(range(len(THINGS)), key=lambda i: distance_m(THINGS[i], result)))
    seen_often = {
        i for i in range(len(THINGS)) if len({max(at - ago, 0) for at, ago, which, _ in frames if which == i}) > 1
    }
    assert len(set(inspected)) == len(inspected)
    assert set(inspected) <= seen_often


def distance_m(thing: Thing, result) -> float:
    if thing.label != result.label:
        return math.inf
    return math.hypot(thing.x_m - result.place_m[0], thing.y_m - result.place_m[1])
