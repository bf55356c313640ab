# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Poses, velocities and ways as messages and back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.messages.cdr import WireError
from edgefusion.messages.from_cmd_vel import from_cmd_vel
from edgefusion.messages.from_goal_pose import from_goal_pose
from edgefusion.messages.from_odometry import from_odometry
from edgefusion.messages.from_path import from_path
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.geometry_msgs import Point, Pose, PoseStamped, Quaternion, Transform, Twist, Vector3
from edgefusion.messages.planar import planar, pose_of
from edgefusion.messages.rotations import quaternion_of, rotation_of
from edgefusion.messages.std_msgs import Header
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.messages.to_goal_pose import to_goal_pose
from edgefusion.messages.to_odometry import to_odometry
from edgefusion.messages.to_path import to_path
from edgefusion.messages.to_transforms import to_transforms
from edgefusion.messages.transform import FrameTransform, mounting, robot_transform
from edgefusion.types import Pose2D, Twist2D
from messages_scenes import STAMP_NS, STAMPER, is_same_pose, poses, sent, stamps_ns

NAN, INF = math.nan, math.inf
speeds = st.floats(-3, 3)
twists = st.builds(Twist2D, speeds, speeds)
quaternions = st.tuples(*[st.floats(-1, 1)] * 4).map(np.array).filter(lambda q: np.linalg.norm(q) > 0.1)


def goal(pose: Pose, frame_id: str = "odom") -> PoseStamped:
    return PoseStamped(Header(frame_id=frame_id), pose)


def test_a_quarter_turn_to_the_left_is_half_of_it_about_z() -> None:
    pose = pose_of(Pose2D(1.0, 2.0, math.pi / 2))
    assert pose.position == Point(1.0, 2.0, 0.0)
    assert (pose.orientation.z, pose.orientation.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))


@given(pose=poses)
def test_a_pose_comes_back(pose: Pose2D) -> None:
    assert is_same_pose(planar(pose_of(pose), "pose"), pose)


@given(q=quaternions)
def test_a_rotation_comes_back(q: np.ndarray) -> None:
    R = rotation_of(Quaternion(*(q / np.linalg.norm(q)).tolist()), "rotation")
    back = quaternion_of(R)
    assert back.w >= 0
    np.testing.assert_allclose(rotation_of(back, "rotation"), R, atol=1e-9)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(R) == pytest.approx(1)


def test_rotations_are_those_of_the_axes() -> None:
    half = math.sqrt(0.5)
    np.testing.assert_allclose(rotation_of(Quaternion(half, 0, 0, half), "x") @ [0, 1, 0], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(rotation_of(Quaternion(0, half, 0, half), "y") @ [0, 0, 1], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(rotation_of(Quaternion(0, 0, half, half), "z") @ [1, 0, 0], [0, 1, 0], atol=1e-12)


@given(stamp_ns=stamps_ns, pose=poses, twist=twists)
def test_odometry_comes_back(stamp_ns: int, pose: Pose2D, twist: Twist2D) -> None:
    message = sent(from_odometry(stamp_ns, pose, twist, STAMPER))
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
    found = to_odometry(message, STAMPER)
    assert (found.stamp_ns, found.twist) == (stamp_ns, twist)
    assert is_same_pose(found.pose, pose)


def test_odometry_that_is_no_number_is_refused() -> None:
    message = from_odometry(STAMP_NS, Pose2D(), Twist2D(), STAMPER)
    fast = replace(message.twist, twist=Twist(Vector3(NAN)))
    with pytest.raises(WireError, match="odometry: expected a finite velocity"):
        to_odometry(replace(message, twist=fast), STAMPER)


@given(twist=twists)
def test_a_velocity_comes_back(twist: Twist2D) -> None:
    assert to_cmd_vel(sent(from_cmd_vel(twist))) == twist


@pytest.mark.parametrize(
    ("twist", "reason"),
    [
        (Twist(Vector3(NAN)), "finite"),
        (Twist(Vector3(INF)), "finite"),
        (Twist(angular=Vector3(z=-INF)), "finite"),
        (Twist(Vector3(y=0.1)), "linear.y: expected 0"),
        (Twist(Vector3(z=0.1)), "linear.z: expected 0"),
        (Twist(angular=Vector3(x=NAN)), "angular.x: expected 0"),
        (Twist(angular=Vector3(y=0.1)), "angular.y: expected 0"),
    ],
)
def test_a_velocity_that_is_none_for_this_robot_is_refused(twist: Twist, reason: str) -> None:
    with pytest.raises(WireError, match=f"^cmd_vel: .*{reason}"):
        to_cmd_vel(twist)


@given(pose=poses, frame_id=st.sampled_from(["odom", "base_link"]))
def test_a_goal_comes_back_in_its_frame(pose: Pose2D, frame_id: str) -> None:
    found = to_goal_pose(sent(from_goal_pose(STAMP_NS, pose, STAMPER, frame_id)))
    assert found.frame_id == frame_id
    assert is_same_pose(found.pose, pose)


def test_a_goal_in_base_link_counts_from_where_the_robot_is() -> None:
    message = from_goal_pose(STAMP_NS, Pose2D(2.0, 0.0, 0.0), STAMPER, "base_link")
    found = to_goal_pose(message).in_odom(Pose2D(1.0, 1.0, math.pi / 2))
    assert (found.x_m, found.y_m, found.theta) == pytest.approx((1.0, 3.0, math.pi / 2))
    in_odom = to_goal_pose(replace(message, header=Header(frame_id="odom")))
    assert in_odom.in_odom(Pose2D(1.0, 1.0, math.pi / 2)) == in_odom.pose


@pytest.mark.parametrize("frame_id", ["", "map", "/odom", "laser", "odom\0", "x" * 4000])
def test_a_goal_in_another_frame_is_refused(frame_id: str) -> None:
    with pytest.raises(WireError, match="goal_pose: expected the frame odom or base_link") as caught:
        to_goal_pose(goal(Pose(), frame_id))
    assert len(str(caught.value)) <= 410


@pytest.mark.parametrize(
    ("pose", "reason"),
    [
        (Pose(Point(NAN)), "expected a place in finite metres"),
        (Pose(Point(z=INF)), "expected a place in finite metres"),
        (Pose(Point(1001.0)), "expected at most 1000 m away"),
        (Pose(Point(1e308, 1e308)), "expected at most 1000 m away"),
        (Pose(orientation=Quaternion(0, 0, NAN, 1)), "expected a quaternion of length 1"),
        (Pose(orientation=Quaternion(0, 0, 0, 0)), "expected a quaternion of length 1"),
        (Pose(orientation=Quaternion(0, 0, 1e300, 1e300)), "expected a quaternion of length 1"),
        (Pose(orientation=Quaternion(1, 0, 0, 0)), "expected it level, got it tilted by 180 degrees"),
    ],
)
def test_a_goal_that_is_no_pose_on_the_ground_is_refused(pose: Pose, reason: str) -> None:
    with pytest.raises(WireError, match=f"^goal_pose: {reason}"):
        to_goal_pose(goal(pose))


def test_a_goal_written_by_hand_is_understood() -> None:
    assert to_goal_pose(goal(Pose(orientation=Quaternion(0, 0, 0.71, 0.71)))).pose.theta == pytest.approx(math.pi / 2)


def test_a_way_comes_back() -> None:
    way = [Pose2D(0.0, 0.0, 0.0), Pose2D(1.0, 0.5, 0.25)]
    message = sent(from_path(STAMP_NS, way, STAMPER))
    assert message.header == message.poses[1].header == STAMPER.header(STAMP_NS, "odom")
    assert all(map(is_same_pose, to_path(message), way))
    assert to_path(sent(from_path(STAMP_NS, [], STAMPER))) == []


def test_a_way_says_which_of_its_poses_is_none() -> None:
    message = from_path(STAMP_NS, [Pose2D(), Pose2D()], STAMPER)
    message.poses[1] = goal(Pose(Point(NAN)))
    with pytest.raises(WireError, match="path: pose 1: expected a place"):
        to_path(message)


def test_a_camera_mounted_above_the_laser_is_where_tf_says() -> None:
    T_base_laser = np.eye(4)
    T_base_laser[:3, 3] = 0.1, 0.0, 0.3
    # Forward for the laser is z for the camera, which is 0.2 m higher.
    T_camera_laser = np.array([[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]], float)
    message = sent(from_transforms(STAMP_NS, mounting(T_base_laser, T_camera_laser), STAMPER))
    (laser_ns, laser), (_, camera) = to_transforms(message, STAMPER)
    assert (laser_ns, laser.parent, laser.child) == (STAMP_NS, "base_link", "laser")
    assert (camera.parent, camera.child) == ("laser", "camera_optical")
    np.testing.assert_allclose(laser.T_parent_child, T_base_laser, atol=1e-12)
    np.testing.assert_allclose(camera.T_parent_child[:3, 3], [0, 0, 0.2], atol=1e-12)
    np.testing.assert_allclose(camera.T_parent_child, np.linalg.inv(T_camera_laser), atol=1e-12)


@given(pose=poses)
def test_the_robot_is_where_tf_says(pose: Pose2D) -> None:
    ((_, found),) = to_transforms(sent(from_transforms(STAMP_NS, [robot_transform(pose)], STAMPER)), STAMPER)
    assert (found.parent, found.child) == ("odom", "base_link")
    np.testing.assert_allclose(found.T_parent_child, pose.matrix(), atol=1e-9)


@pytest.mark.parametrize(
    ("child", "transform", "reason"),
    [
        ("", Transform(), "expected the names of two frames"),
        ("laser", Transform(Vector3(INF)), "tf: laser: expected a place"),
        ("laser", Transform(rotation=Quaternion(w=0.0)), "tf: laser: expected a quaternion"),
    ],
)
def test_a_transform_that_is_none_is_refused(child: str, transform: Transform, reason: str) -> None:
    (message,) = from_transforms(STAMP_NS, [robot_transform(Pose2D())], STAMPER).transforms
    with pytest.raises(WireError, match=reason):
        to_transforms(TFMessage([replace(message, child_frame_id=child, transform=transform)]), STAMPER)


def test_a_transform_is_a_matrix_of_four_by_four_numbers() -> None:
    for T in (np.eye(3), np.full((4, 4), NAN)):
        with pytest.raises(ValueError, match="T_parent_child: expected finite numbers"):
            FrameTransform("odom", "base_link", T)
