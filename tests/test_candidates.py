# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Every setting of the boxes changes them as docs/perception.md says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.candidates import find_candidates
from edgefusion.types import Scan
from scene import CAMERA_ABOVE_LASER_M, FOCAL_PX, HEIGHT, LASER_HEIGHT_M, T_CAMERA_LASER, WIDTH, K

CALIBRATION = Calibration((WIDTH, HEIGHT), K, (), T_CAMERA_LASER, np.eye(4), LASER_HEIGHT_M)
DISTANCE_M = 2.0


def scan_of(bearing: float = 0.0) -> Scan:
    """Nine beams, half a degree apart, onto something flat 2 m ahead of the laser."""
    angles = bearing + np.radians(0.5) * np.arange(-4, 5)
    return Scan(0, (DISTANCE_M / np.cos(angles)).astype(np.float32), float(angles[0]), float(np.radians(0.5)))


def boxes_of(scan: Scan | None = None, **config) -> np.ndarray:
    found = find_candidates(scan or scan_of(), T_CAMERA_LASER, CALIBRATION, PerceptionConfig(**config))
    return found[0].boxes if found else np.empty((0, 4), int)


def size(box: np.ndarray) -> tuple[int, int]:
    return box[2] - box[0], box[3] - box[1]


def row_px(below_camera_m: float) -> float:
    return K[1, 2] + FOCAL_PX * below_camera_m / DISTANCE_M


def test_heights_in_widths_are_multiples_of_the_width_in_pixels() -> None:
    for height, box in zip((0.5, 1.0, 2.0), boxes_of(heights=(0.5, 1.0, 2.0))):
        assert size(box)[1] == pytest.approx(height * size(box)[0], abs=2)


def test_heights_in_metres_are_metres_at_the_objects_distance() -> None:
    for height, box in zip((0.2, 0.5), boxes_of(heights=(0.2, 0.5), heights_in="metres")):
        assert size(box)[1] == pytest.approx(FOCAL_PX * height / DISTANCE_M, abs=2)


def test_width_step_makes_each_box_wider_than_the_one_before() -> None:
    plain = boxes_of(heights=(1.0, 1.0, 1.0))
    wider = boxes_of(heights=(1.0, 1.0, 1.0), width_step=0.5)
    for k, (box, widened) in enumerate(zip(plain, wider)):
        assert size(widened)[0] == pytest.approx((1 + 0.5 * k) * size(box)[0], abs=2)


def test_the_bottom_is_on_the_ground_or_on_the_scan_line() -> None:
    (ground,) = boxes_of(heights=(1.0,), bottom="ground")
    (scan,) = boxes_of(heights=(1.0,), bottom="scan")
    assert ground[3] == pytest.approx(row_px(CAMERA_ABOVE_LASER_M + LASER_HEIGHT_M), abs=2)
    assert scan[3] == pytest.approx(row_px(CAMERA_ABOVE_LASER_M), abs=2)


def test_a_box_of_which_less_than_min_visible_is_inside_is_dropped() -> None:
    edge = scan_of(bearing=-np.arctan(WIDTH / 2 / FOCAL_PX))  # its middle is on the image's right edge
    assert len(boxes_of(edge, heights=(1.0,), min_visible=0.3)) == 1
    assert len(boxes_of(edge, heights=(1.0,), min_visible=0.7)) == 0


def test_wider_than_max_object_width_is_no_object() -> None:
    width_m = 2 * DISTANCE_M * math.tan(math.radians(2))
    assert len(boxes_of(max_object_width_m=width_m + 0.01))
    assert not len(boxes_of(max_object_width_m=width_m - 0.01))


def wide_scan(right_m: float, left_m: float) -> Scan:
    """A flat thing 2 m ahead and 3.5 m wide, and so far a range on either side of it."""
    angles = np.radians(np.arange(-60, 60.1, 0.5))
    ranges_m = DISTANCE_M / np.cos(angles)
    half = math.atan(1.75 / DISTANCE_M)
    ranges_m = np.where(angles < -half, right_m, np.where(angles > half, left_m, ranges_m))
    return Scan(0, ranges_m.astype(np.float32), float(angles[0]), float(np.radians(0.5)))


@pytest.mark.parametrize(
    ("right_m", "left_m", "found"),
    [(6.0, 6.0, True), (math.inf, math.inf, True), (6.0, 1.0, False), (1.0, 6.0, False), (math.nan, math.nan, False)],
)
def test_what_is_wide_is_an_object_only_where_both_ends_stand_out(right_m: float, left_m: float, found: bool) -> None:
    boxes = boxes_of(wide_scan(right_m, left_m), max_flush_width_m=3.0, objects=1, eps_m=0.3)
    nearest_is_wide = len(boxes) > 0 and size(boxes[0])[0] > WIDTH // 2
    assert nearest_is_wide == found


def test_a_dropped_beam_beside_an_end_hides_nothing() -> None:
    scan = wide_scan(6.0, 6.0)
    ranges_m = scan.ranges_m.copy()
    ranges_m[np.flatnonzero(ranges_m == 6.0)[[len(np.flatnonzero(ranges_m == 6.0)) // 2 - 1]]] = np.nan
    dropped = Scan(0, ranges_m, scan.angle_min, scan.angle_increment)
    assert len(boxes_of(dropped, max_flush_width_m=3.0, objects=1))


def test_the_sensors_limits_hide_what_lies_outside() -> None:
    near = scan_of()
    for limits in ({"range_min_m": 2.5}, {"range_max_m": 1.5}):
        hidden = Scan(0, near.ranges_m, near.angle_min, near.angle_increment, **limits)
        assert not len(boxes_of(hidden))
