# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where things are in base_link and after the robot has moved, with the laser off its origin and upside down."""

from __future__ import annotations

import numpy as np
import pytest

from edgefusion.perception.calibration import Calibration
from edgefusion.perception.motion import laser_motion, shift_px, transform
from edgefusion.types import STILL, Pose2D
from scene import FOCAL_PX, HEIGHT, LASER_HEIGHT_M, T_CAMERA_LASER, WIDTH, K

UPSIDE_DOWN = np.array([[1, 0, 0, 0.2], [0, -1, 0, 0.1], [0, 0, -1, 0.3], [0, 0, 0, 1]], float)
POINT = np.array([2.0, -0.5, 0.0])  # of the laser: 2.2 m ahead of base_link and 0.6 m to its left


def test_a_robot_that_stood_still_moves_nothing() -> None:
    assert (laser_motion(STILL, UPSIDE_DOWN) == np.eye(4)).all()


@pytest.mark.parametrize(
    ("motion", "expected"),
    [
        (Pose2D(x_m=0.5), (1.7, 0.6)),
        (Pose2D(y_m=0.5), (2.2, 0.1)),
        (Pose2D(theta=np.pi / 2), (0.6, -2.2)),  # a left turn about base_link, not about the laser
        (Pose2D(0.2, 0.6, np.pi / 2), (0.0, -2.0)),
    ],
)
def test_a_point_is_where_the_moved_robot_sees_it(motion: Pose2D, expected: tuple[float, float]) -> None:
    moved = transform(laser_motion(motion, UPSIDE_DOWN), POINT)
    x_m, y_m, z_m = transform(UPSIDE_DOWN, moved)
    assert (x_m, y_m, z_m) == pytest.approx((*expected, 0.3))


def test_the_shift_in_the_image_is_that_of_the_projection() -> None:
    calibration = Calibration((WIDTH, HEIGHT), K, (), T_CAMERA_LASER, np.eye(4), LASER_HEIGHT_M)
    ahead, beside = np.array([2.0, 0.0, 0.0]), np.array([2.0, 0.1, 0.0])
    assert shift_px(ahead, beside, calibration) == pytest.approx(FOCAL_PX * 0.05)
    assert np.isnan(shift_px(ahead, -ahead, calibration))
