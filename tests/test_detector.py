# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Algorithm 1 on a scene of known truth, with a network whose answers are known, and on a real drive."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.clusters import find_clusters
from edgefusion.perception.detector import Detector
from edgefusion.perception.groups import LabelGroups
from edgefusion.recording.folder import FolderRecording
from edgefusion.types import STILL, UNKNOWN, Frame, Pose2D, Scan
from make_colour_network import open_colour_network
from scene import OBJECTS, STEP_M, nearest_m, write_recording

COLOURS = {solid.name: solid.color for solid in OBJECTS}


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> FolderRecording:
    return FolderRecording(write_recording(tmp_path_factory.mktemp("scene") / "drive", seed=1))


@pytest.fixture(scope="module")
def classifier(tmp_path_factory):
    return open_colour_network(tmp_path_factory.mktemp("network"), COLOURS)


@pytest.fixture(scope="module")
def make_detector(scene, classifier):
    calibration = load_calibration(scene.calibration_path)
    return lambda **config: Detector(classifier, calibration, PerceptionConfig(**config))


@pytest.mark.parametrize("index", [0, 3, 5])
def test_every_object_of_the_scene_is_found_named_and_measured(scene, make_detector, index: int) -> None:
    found = make_detector(max_object_width_m=1.2).detect(scene.scan(index), scene.frame(index))
    for solid in OBJECTS:
        truth_m = nearest_m(solid, index * STEP_M)
        detection = min(found, key=lambda d: abs(d.distance_m - truth_m))
        assert abs(detection.distance_m - truth_m) < 3 * detection.distance_sigma_m
        assert detection.label == solid.name
        assert np.hypot(*detection.position_m) == pytest.approx(detection.distance_m)


def test_detections_come_nearest_first_and_at_most_as_many_as_asked_for(scene, make_detector) -> None:
    distances = [d.distance_m for d in make_detector(objects=2).detect(scene.scan(0), scene.frame(0))]
    assert len(distances) == 2
    assert distances == sorted(distances)
    (nearest,) = make_detector(objects=1).detect(scene.scan(0), scene.frame(0))  # the paper
    assert nearest.label == "post"


def test_a_wall_is_background_and_not_named(scene, make_detector) -> None:
    config = PerceptionConfig(max_object_width_m=1.2)
    walls = [c for c in find_clusters(scene.scan(0), config) if c.width_m > 1.2]
    assert len(walls) == 2
    detections = make_detector(max_object_width_m=1.2).detect(scene.scan(0), scene.frame(0))
    assert not {d.cluster.indices[0] for d in detections} & {wall.indices[0] for wall in walls}


def test_the_papers_features_find_the_same_objects_ahead(scene, make_detector) -> None:
    detections = make_detector(features="yr", distance="minimum").detect(scene.scan(0), scene.frame(0))
    assert {"post", "crate", "drum"} <= {d.label for d in detections}


def test_the_answer_carries_the_whole_vote(scene, make_detector) -> None:
    detection = make_detector().detect(scene.scan(0), scene.frame(0))[0]
    assert len(detection.boxes) == len(detection.vote.top5) == 3
    assert detection.box == detection.boxes[detection.vote.box_index]
    assert detection.score == detection.vote.ranking[0].score
    assert detection.margin == pytest.approx(detection.score - detection.vote.ranking[1].score)
    assert detection.stamp_ns == scene.frame(0).stamp_ns


def test_a_weak_vote_is_unknown_but_still_measured(scene, make_detector) -> None:
    sure = make_detector().detect(scene.scan(0), scene.frame(0))[0]
    for limit in ({"min_score": 1.0}, {"min_margin": 1.0}):
        unsure = make_detector(**limit).detect(scene.scan(0), scene.frame(0))[0]
        assert (unsure.label, unsure.group) == (UNKNOWN, "")
        assert unsure.class_index == sure.class_index
        assert (unsure.distance_m, unsure.score, unsure.box) == (sure.distance_m, sure.score, sure.box)


def test_the_motion_between_scan_and_frame_moves_the_box_and_the_distance(scene, make_detector) -> None:
    """The scan of frame 0 with the picture of frame 3, 0.24 m later."""
    detector = make_detector(max_object_width_m=1.2)
    motion = Pose2D(x_m=3 * STEP_M)
    moved = detector.detect(scene.scan(0), scene.frame(3), motion)[0]
    still = detector.detect(scene.scan(0), scene.frame(3))[0]
    truth = detector.detect(scene.scan(3), scene.frame(3))[0]
    assert moved.distance_m == pytest.approx(truth.distance_m, abs=0.03)
    assert (
        np.abs(np.subtract(moved.boxes[0], truth.boxes[0])).max()
        < np.abs(np.subtract(still.boxes[0], truth.boxes[0])).max()
    )
    assert moved.scan_frame_dt_ns == 600_000_000
    assert moved.motion == motion
    assert moved.motion_px > 2
    assert still.motion_px == 0


def test_a_turn_shifts_the_object_by_its_angle_in_pixels(scene, make_detector) -> None:
    detection = make_detector(objects=1).detect(scene.scan(0), scene.frame(0), Pose2D(theta=np.radians(2)))[0]
    still = make_detector(objects=1).detect(scene.scan(0), scene.frame(0))[0]
    assert detection.bearing == pytest.approx(still.bearing - np.radians(2))
    assert detection.distance_m == pytest.approx(still.distance_m)
    expected = 460 * abs(np.tan(still.bearing) - np.tan(detection.bearing))
    assert detection.motion_px == pytest.approx(expected, rel=1e-3)  # and a little up or down


MOUNTED = np.array([[1, 0, 0, 0.2], [0, -1, 0, 0.1], [0, 0, -1, 0.25], [0, 0, 0, 1]], float)
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])


@pytest.mark.parametrize("motion", [STILL, Pose2D(x_m=0.3), Pose2D(0.1, -0.2, 0.3)])
def test_a_laser_upside_down_and_off_the_origin_gives_the_same_objects_in_base_link(
    scene, classifier, motion: Pose2D
) -> None:
    """The scene's laser, mounted upside down 0.2 m ahead and 0.1 m left: its beams come in the other order."""
    level = load_calibration(scene.calibration_path)
    upright = replace(level, T_base_laser=MOUNTED @ FLIP)
    flipped = replace(level, T_base_laser=MOUNTED, T_camera_laser=level.T_camera_laser @ FLIP)
    scan = scene.scan(0)
    mirrored = replace(scan, ranges_m=scan.ranges_m[::-1])
    expected = Detector(classifier, upright).detect(scan, scene.frame(0), motion)
    found = Detector(classifier, flipped).detect(mirrored, scene.frame(0), motion)
    assert len(found) == len(expected) > 0
    for one, other in zip(found, expected):
        assert one.position_m == pytest.approx(other.position_m)
        assert (one.distance_m, one.bearing) == pytest.approx((other.distance_m, other.bearing))
        from_laser = np.subtract(one.position_m, (0.2, 0.1))
        assert np.hypot(*from_laser) == pytest.approx(one.distance_m)
        assert np.arctan2(*from_laser[::-1]) == pytest.approx(one.bearing)
    post = min(OBJECTS, key=lambda solid: nearest_m(solid, 0.0))
    if motion == STILL:  # its axis is (1.7, -0.22) of the laser
        assert found[0].label == post.name
        assert found[0].position_m == pytest.approx((1.85, -0.11), abs=0.05)


def test_the_weighted_height_rule_gives_a_mean_of_the_boxes(scene, make_detector) -> None:
    papers = make_detector(objects=1).detect(scene.scan(0), scene.frame(0))[0]
    weighted = make_detector(objects=1, height_rule="weighted").detect(scene.scan(0), scene.frame(0))[0]
    assert papers.box in papers.boxes
    assert weighted.box not in weighted.boxes
    low, high = np.min(weighted.boxes, axis=0), np.max(weighted.boxes, axis=0)
    assert ((low <= weighted.box) & (weighted.box <= high)).all()


def test_the_distance_and_its_sigma_follow_the_settings(scene, make_detector) -> None:
    def nearest(**config):
        return make_detector(objects=1, **config).detect(scene.scan(0), scene.frame(0))[0]

    minimum = nearest(distance="minimum", range_sigma_m=0.02)
    assert minimum.distance_m == pytest.approx(minimum.cluster.range_m)
    assert minimum.distance_sigma_m == 0.02
    assert nearest().distance_m > minimum.distance_m  # a minimum over noise is too near
    assert nearest(range_sigma_m=0.05).distance_sigma_m > nearest().distance_sigma_m


def test_a_detection_carries_the_group_of_its_label(scene, classifier, make_detector) -> None:
    groups = LabelGroups({"pillar": ["post", "column"]})
    calibration = load_calibration(scene.calibration_path)
    grouped = Detector(classifier, calibration, groups=groups)
    assert grouped.detect(scene.scan(0), scene.frame(0))[0].group == "pillar"
    assert make_detector().detect(scene.scan(0), scene.frame(0))[0].group == ""


def test_a_frame_of_another_size_is_refused(scene, make_detector) -> None:
    frame = Frame(0, np.zeros((240, 320, 3), np.uint8))
    with pytest.raises(ValueError, match="the calibration expects 640x480, got 320x240"):
        make_detector().detect(scene.scan(0), frame)


special = st.sampled_from([np.nan, np.inf, -np.inf, 0.0, -1.0, 1e-6, 1e30])


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.one_of(st.floats(0.015625, 30, width=32), special), min_size=0, max_size=400),
    st.floats(-4, 4),
    st.floats(-4, 4),
    st.floats(-7, 7),
)
def test_no_scan_and_no_motion_make_it_raise(scene, make_detector, ranges, x, y, theta) -> None:
    scan = Scan(0, np.array(ranges, np.float32), -np.pi / 2, np.radians(0.5))
    for detection in make_detector().detect(scan, scene.frame(0), Pose2D(x, y, theta)):
        x0, y0, x1, y1 = detection.box
        assert 0 <= x0 < x1 <= 640
        assert 0 <= y0 < y1 <= 480
        assert np.isfinite(detection.distance_m)


def test_the_same_input_gives_the_same_answer_twice(scene, make_detector) -> None:
    first, second = (make_detector().detect(scene.scan(2), scene.frame(2)) for _ in range(2))
    assert [replace(d, cluster=None) for d in first] == [replace(d, cluster=None) for d in second]


@pytest.fixture(scope="module")
def real_drive(shared_data: Path):
    recording = FolderRecording(shared_data / "kitti-drive")
    return recording, load_calibration(recording.calibration_path)


def test_the_car_ahead_is_found_and_measured_in_every_frame_of_the_real_drive(shared_data, real_drive) -> None:
    recording, calibration = real_drive
    models = shared_data / "models"
    classifier = open_classifier(models / "mobilenetv2_fp32_dequant.onnx", labels=models / "imagenet_classes.txt")
    detector = Detector(classifier, calibration)
    truths = json.loads((shared_data / "kitti-drive" / "truth_0_29.json").read_text(encoding="utf-8"))
    for truth in truths[::3]:
        index = truth["frame"]
        detections = detector.detect(recording.scan(index), recording.frame(index))
        ahead = min(detections, key=lambda d: abs(d.distance_m - truth["distance"]))
        assert ahead.group == "car"
        assert abs(ahead.distance_m - truth["distance"]) < 0.02
