# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A rig that the simulator would render or scan wrongly is refused, with one line that says why."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.sim.rig import Matrix, Rig, rigid
from edgefusion.types import Pose2D

X, Y, Z = np.eye(3)
MOUNTED = Rig().T_base_laser[:3, 3]


def mounted(**transforms: Matrix) -> None:
    rig = Rig()
    Rig(
        T_camera_laser=transforms.get("T_camera_laser", rig.T_camera_laser),
        T_base_laser=transforms.get("T_base_laser", rig.T_base_laser),
    )


def turned(axis: np.ndarray, degrees: float) -> np.ndarray:
    return np.asarray(cv2.Rodrigues(axis * math.radians(degrees))[0])


def camera(axis: np.ndarray, degrees: float) -> np.ndarray:
    """The default camera, turned about one of its own axes."""
    T = Rig().T_camera_laser
    return rigid(turned(axis, degrees) @ T[:3, :3], T[:3, 3])


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(0.05, 2), st.floats(-180, 180))
def test_a_level_laser_stands_where_and_looks_whither_it_is_mounted(x: float, y: float, z: float, yaw: float) -> None:
    rig = Rig(T_base_laser=rigid(turned(Z, yaw), (x, y, z)))
    pose = rig.laser_pose(Pose2D())
    assert (pose.x_m, pose.y_m, rig.laser_height_m) == (x, y, z)
    assert math.remainder(pose.theta - math.radians(yaw), 2 * math.pi) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("R", [turned(X, 180), turned(Y, 180), turned(Y, 2), turned(X, -0.01)])
def test_a_laser_upside_down_or_tilted_is_refused(R: np.ndarray) -> None:
    with pytest.raises(RefusedError, match=r"^T_base_laser: expected a level, upright laser, got "):
        Rig(T_base_laser=rigid(R, MOUNTED))


@pytest.mark.parametrize("height_m", [0.0, -0.2, math.nan, math.inf])
def test_a_laser_that_is_not_above_the_ground_is_refused(height_m: float) -> None:
    with pytest.raises(RefusedError, match=r"^T_base_laser: expected a laser above the ground, got a height of "):
        Rig(T_base_laser=rigid(np.eye(3), (0.1, 0.0, height_m)))


@pytest.mark.parametrize("T", [camera(X, 20), camera(X, -20), camera(Y, 35)])
def test_a_camera_may_look_up_down_and_aside(T: np.ndarray) -> None:
    right = Rig(T_camera_laser=T).T_world_camera(Pose2D())[:3, 0]
    assert right[2] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("T", [camera(Z, 1), camera(Z, 180), camera(Z, 0.001), camera(X, 90)])
def test_a_camera_that_rolls_or_looks_straight_up_or_down_is_refused(T: np.ndarray) -> None:
    with pytest.raises(RefusedError, match=r"^T_camera_laser: expected a camera without roll, the ground below, got "):
        Rig(T_camera_laser=T)


@pytest.mark.parametrize("name", ["T_camera_laser", "T_base_laser"])
def test_what_is_no_rotation_is_refused(name: str) -> None:
    for R in (1.01 * np.eye(3), np.diag([1, -1, 1]), np.full((3, 3), np.nan)):
        with pytest.raises(RefusedError, match=f"^{name}: expected a rotation and a translation, got "):
            mounted(**{name: rigid(R, MOUNTED)})
    with pytest.raises(RefusedError, match=rf"^{name}: expected shape \[4, 4\], got \[3, 3\]$"):
        mounted(**{name: np.eye(3)})


@pytest.mark.parametrize("size", [(0, 480), (640, -1)])
def test_a_picture_without_pixels_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(RefusedError, match=r"^image_size: expected .width, height. above 0, got "):
        Rig(image_size=size)


def test_intrinsics_of_another_shape_are_refused() -> None:
    with pytest.raises(RefusedError, match=r"^K: expected shape \[3, 3\], got \[3, 4\]$"):
        Rig(K=np.ones((3, 4)))
