# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One frame's detections beside the truth: who is found, who is counted twice, what the errors are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from edgefusion.sim.rig import Rig
from edgefusion.sim.snapshot import Snapshot
from edgefusion.sim.truth import ObjectTruth
from edgefusion.tools.geometry import calibration_of, iou
from edgefusion.tools.measure import compare
from edgefusion.types import STILL, UNKNOWN, ClassScore, Cluster, Detection, Frame, Scan, Vote

CALIBRATION = calibration_of(Rig())
BEAMS = 361
VOTE = Vote((ClassScore(0, "washer", 0.9),), 0, 0.9, ((ClassScore(0, "washer", 0.9),),))
WASHER = ObjectTruth(
    index=0, name="washer 1", kind="washer", label="washer", box=(300, 200, 360, 320), full_box=(300, 200, 360, 320),
    range_m=2.0, occlusion=0.0, beams=20,
)  # fmt: skip
CONE = replace(WASHER, index=1, name="cone 1", kind="traffic cone", label=UNKNOWN, box=(400, 220, 440, 320))


def shot_of(owners: np.ndarray, *truth: ObjectTruth) -> Snapshot:
    """A scan of something 2 m away all around, in which every beam met its owner's surface."""
    scan = Scan(0, np.full(BEAMS, 2.0, np.float32), -np.pi / 2, np.radians(0.5))
    fields = {"scan": scan, "frame": Frame(0, np.zeros((480, 640, 3), np.uint8)), "motion": STILL, "owners": owners,
              "truth": truth, "laser": STILL}  # fmt: skip
    return Snapshot(**{name: fields[name] for name in Snapshot.__dataclass_fields__})


def detection(beams: range, label: str = "washer", box=(300, 200, 360, 320), distance_m: float = 2.0) -> Detection:
    cluster = Cluster(np.array(beams), distance_m, 0.0, 0.3)
    return Detection(
        stamp_ns=0, class_index=0, label=label, group="", score=0.9, margin=0.9, box=box, distance_m=distance_m,
        distance_sigma_m=0.01, bearing=0.0, position_m=(distance_m, 0.0), vote=VOTE, boxes=(box,), cluster=cluster,
        scan_frame_dt_ns=0,
    )  # fmt: skip


def owners(*parts: tuple[range, int]) -> np.ndarray:
    """Whose surface each beam met: nothing's, where no part says otherwise."""
    whose = np.full(BEAMS, -2, np.int32)
    for beams, owner in parts:
        whose[beams.start : beams.stop] = owner
    return whose


AHEAD = range(170, 190)
"""Beams that fall into the image."""


def test_an_object_is_found_by_the_cluster_that_is_mostly_its_own() -> None:
    shot = shot_of(owners((AHEAD, 0)), WASHER)
    (seen,), (claim,) = compare(shot, [detection(range(168, 190))], CALIBRATION, [1.0], "w", 3)
    assert (seen.found, seen.named, seen.said, seen.frame) == (True, True, "washer", 3)
    assert (claim.real, claim.named, claim.right) == (True, True, True)


def test_an_object_without_a_detection_is_missed_and_has_no_errors() -> None:
    (seen,), claims = compare(shot_of(owners((AHEAD, 0)), WASHER), [], CALIBRATION, [1.0], "w", 0)
    assert not seen.found
    assert seen.iou is None
    assert claims == []


def test_of_two_detections_of_one_object_the_larger_counts_and_the_other_is_nobodys() -> None:
    shot = shot_of(owners((AHEAD, 0)), WASHER)
    small, large = detection(range(170, 175), distance_m=2.2), detection(range(175, 190))
    (seen,), claims = compare(shot, [small, large], CALIBRATION, [1.0], "w", 0)
    assert seen.distance_error_m == pytest.approx(0.0)
    assert [claim.real for claim in claims] == [False, True]


def test_a_wall_that_is_detected_is_no_object() -> None:
    shot = shot_of(owners((AHEAD, -1)))
    seen, (claim,) = compare(shot, [detection(AHEAD, UNKNOWN)], CALIBRATION, [], "w", 0)
    assert seen == []
    assert (claim.real, claim.named, claim.right) == (False, False, False)


def test_unknown_is_the_right_label_of_what_has_no_name_but_names_nothing() -> None:
    shot = shot_of(owners((AHEAD, 1)), CONE)
    (seen,), (claim,) = compare(shot, [detection(AHEAD, UNKNOWN)], CALIBRATION, [1.0, 1.0], "w", 0)
    assert seen.named
    assert (claim.real, claim.named) == (True, False)
    (seen,), (claim,) = compare(shot, [detection(AHEAD, "washer")], CALIBRATION, [1.0, 1.0], "w", 0)
    assert not seen.named
    assert (claim.named, claim.right) == (True, False)


def test_errors_are_the_detections_minus_the_truths() -> None:
    shot = shot_of(owners((AHEAD, 0)), WASHER)
    box = (296, 170, 366, 320)
    (seen,), _ = compare(shot, [detection(AHEAD, box=box, distance_m=2.015)], CALIBRATION, [1.0], "w", 0)
    assert seen.iou == pytest.approx(iou(box, WASHER.box))
    assert seen.height_error == pytest.approx(30 / 120)
    assert seen.width_error_px == 10
    assert seen.distance_error_m == pytest.approx(0.015)
    assert seen.sigma_m == 0.01


def test_only_measured_beams_that_fall_into_the_image_count() -> None:
    shot = shot_of(owners((AHEAD, 0), (range(0, 20), 0)), replace(WASHER, beams=40))
    (seen,), _ = compare(shot, [], CALIBRATION, [0.7], "w", 0)
    assert (seen.beams, seen.in_view, seen.clearance_m) == (20, 0.5, 0.7)
    ranges_m = shot.scan.ranges_m.copy()
    ranges_m[AHEAD.start : AHEAD.start + 4] = np.nan
    dropped = replace(shot, scan=replace(shot.scan, ranges_m=ranges_m))
    assert compare(dropped, [], CALIBRATION, [0.7], "w", 0)[0][0].beams == 16
