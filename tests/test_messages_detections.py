# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Detections as messages and back."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.messages.camera_view import CameraView
from edgefusion.messages.cdr import WireError
from edgefusion.messages.from_detections import from_detections
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.types import UNKNOWN, ClassScore, Cluster, Detection, Pose2D, Vote
from messages_scenes import STAMP_NS, STAMPER, sent

SCORES = tuple(ClassScore(i, f"label {i}", 0.5 - 0.05 * i) for i in range(7))
DETECTION = Detection(
    stamp_ns=STAMP_NS,
    class_index=0,
    label="label 0",
    group="first",
    score=0.5,
    margin=0.05,
    box=(1, 2, 30, 40),
    distance_m=2.0,
    distance_sigma_m=0.1,
    bearing=0.0,
    position_m=(2.1, 0.0),
    vote=Vote(SCORES, box_index=1, margin=0.05, top5=(SCORES[1:6], SCORES[:5])),
    boxes=((1, 2, 30, 20), (1, 2, 30, 40)),
    cluster=Cluster(np.arange(4), 1.2, -1 / 3, 0.4),
    scan_frame_dt_ns=-25_000_000,
    motion=Pose2D(0.1, 0.2, 0.3),
    motion_px=4.5,
)
T_BASE_LASER = np.eye(4)
T_BASE_LASER[:3, 3] = 0.1, 0.0, 0.3
# Forward for the laser is z for the camera, which is 0.2 m higher.
T_CAMERA_LASER = np.array([[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]], float)
VIEW = CameraView(T_CAMERA_LASER, T_BASE_LASER, bearing_sigma=0.01)


def assert_same(found: Detection, expected: Detection) -> None:
    """Equal in all; arrays have no equality of their own."""
    np.testing.assert_array_equal(found.cluster.indices, expected.cluster.indices)
    cluster = replace(found.cluster, indices=expected.cluster.indices)
    assert replace(found, cluster=cluster) == replace(expected, cluster=replace(expected.cluster))


def changed(**changes: object) -> String:
    """The detail of a frame, with its only detection changed."""
    content = json.loads(from_detections_detail(STAMP_NS, [DETECTION]).data)
    content["detections"][0].update(changes)
    return String(json.dumps(content))


def test_a_detection_comes_back_exactly() -> None:
    odd = replace(DETECTION, score=0.1 + 0.2, distance_m=float(np.float32(1.1)), bearing=math.pi)
    found = to_detections_detail(sent(from_detections_detail(STAMP_NS, [odd, DETECTION])))
    assert found.stamp_ns == STAMP_NS
    for one, expected in zip(found.detections, (odd, DETECTION)):
        assert_same(one, expected)
    assert not found.detections[0].cluster.indices.flags.writeable


def test_a_frame_without_detections_comes_back_too() -> None:
    assert to_detections_detail(sent(from_detections_detail(STAMP_NS, []))) == (STAMP_NS, ())


def test_a_motion_that_is_not_known_in_pixels_comes_back_so() -> None:
    message = from_detections_detail(STAMP_NS, [replace(DETECTION, motion_px=math.nan)])
    assert json.loads(message.data)["detections"][0]["motion_px"] is None
    assert math.isnan(to_detections_detail(message).detections[0].motion_px)


def test_a_box_without_an_answer_keeps_its_place_in_the_vote() -> None:
    vote = replace(DETECTION.vote, top5=((), SCORES[:5]))
    (found,) = to_detections_detail(from_detections_detail(STAMP_NS, [replace(DETECTION, vote=vote)])).detections
    assert found.vote == vote


def test_a_number_that_is_not_finite_does_not_leave_the_robot() -> None:
    with pytest.raises(RefusedError, match="distance_m: expected a finite number, got nan"):
        from_detections_detail(STAMP_NS, [replace(DETECTION, distance_m=math.nan)])


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (String(""), "truncated"),
        (String("{}"), "missing required field"),
        (String('{"version":2,"stamp_ns":1,"detections":[]}'), "Invalid enum value 2"),
        (String('{"stamp_ns":1,"detections":[],"more":1}'), "unknown field `more`"),
        (String("[" * 100_000), ""),
        (String("\udcff"), ""),
        (String(" " * (1 << 22) + "{}"), "expected at most 4194304 characters"),
        (changed(score=None), "Expected `float`, got `null`"),
        (changed(score="0.5"), "Expected `float`, got `str`"),
        (changed(score=math.nan), ""),
        (changed(motion=[0.0, 0.0]), "length 3"),
        (changed(boxes=[]), "boxes: 0, but 2 votes"),
        (changed(vote={"ranking": [], "box_index": 0, "margin": 0.0, "top5": [[], []]}), "expected at least one class"),
        (changed(cluster={"indices": [2**70], "range_m": 1.0, "bearing": 0.0, "width_m": 0.0}), ""),
        (changed(cluster={"indices": [2**63], "range_m": 1.0, "bearing": 0.0, "width_m": 0.0}), ""),
    ],
)
def test_what_is_no_detail_is_refused(message: String, reason: str) -> None:
    with pytest.raises(WireError, match=f"^detections/detail: .*{reason}"):
        to_detections_detail(message)


def test_a_detection_is_a_box_with_labels_the_best_first() -> None:
    message = sent(from_detections(STAMP_NS, [DETECTION], VIEW, STAMPER))
    (found,) = message.detections
    assert message.header == found.header == STAMPER.header(STAMP_NS, "camera_optical")
    labels = [(result.hypothesis.class_id, result.hypothesis.score) for result in found.results]
    assert labels == [(score.label, score.score) for score in SCORES[:5]]
    assert (found.bbox.center.position.x, found.bbox.center.position.y) == (15.5, 21.0)
    assert (found.bbox.size_x, found.bbox.size_y, found.id) == (29.0, 38.0, "")


def test_what_cannot_be_named_is_unknown_with_what_it_might_have_been() -> None:
    (found,) = from_detections(STAMP_NS, [replace(DETECTION, label=UNKNOWN)], VIEW, STAMPER).detections
    assert [result.hypothesis.class_id for result in found.results[:2]] == [UNKNOWN, "label 1"]


def test_a_detection_is_where_the_camera_sees_it() -> None:
    (found,) = from_detections(STAMP_NS, [DETECTION], VIEW, STAMPER).detections
    at = found.results[0].pose.pose.position
    # 2 m before the laser, which is 0.2 m below the camera.
    assert (at.x, at.y, at.z) == pytest.approx((0.0, 0.2, 2.0))
    assert found.results[1].pose == found.results[0].pose


def test_it_is_known_along_the_beam_by_the_range_and_across_it_by_the_bearing() -> None:
    (found,) = from_detections(STAMP_NS, [DETECTION], VIEW, STAMPER).detections
    covariance = np.reshape(found.results[0].pose.covariance, (6, 6))
    np.testing.assert_allclose(covariance[:3, :3], np.diag([0.02**2, 0.0, 0.1**2]), atol=1e-12)
    np.testing.assert_allclose(covariance[3:, 3:], np.eye(3) * math.pi**2)
    aside = replace(DETECTION, bearing=math.pi / 2, position_m=(0.1, 2.0))
    (found,) = from_detections(STAMP_NS, [aside], VIEW, STAMPER).detections
    covariance = np.reshape(found.results[0].pose.covariance, (6, 6))
    np.testing.assert_allclose(covariance[:3, :3], np.diag([0.1**2, 0.0, 0.02**2]), atol=1e-12)
