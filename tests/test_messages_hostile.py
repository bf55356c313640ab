# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whatever a message holds: it is understood, or refused with WireError."""

from __future__ import annotations

import json
import math
from typing import Any, Callable

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from any_message import any_message
from edgefusion.messages import Message
from edgefusion.messages.cdr import WireError
from edgefusion.messages.diagnostic_msgs import DiagnosticArray, DiagnosticStatus, KeyValue
from edgefusion.messages.from_healths import HARDWARE, STATE
from edgefusion.messages.geometry_msgs import Pose, PoseStamped, Twist
from edgefusion.messages.nav_msgs import Odometry, Path
from edgefusion.messages.sensor_msgs import BatteryState, CameraInfo, CompressedImage, LaserScan
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.std_msgs import Header, String
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.to_battery import to_battery
from edgefusion.messages.to_camera_info import to_camera_info
from edgefusion.messages.to_clusters import to_clusters
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.messages.to_goal_pose import FARTHEST_M, to_goal_pose
from edgefusion.messages.to_healths import to_healths
from edgefusion.messages.to_image import to_image
from edgefusion.messages.to_mission import to_inspection, to_mission
from edgefusion.messages.to_odometry import to_odometry
from edgefusion.messages.to_path import to_path
from edgefusion.messages.to_scan import to_scan
from edgefusion.messages.to_transforms import to_transforms
from edgefusion.messages.visualization_msgs import MarkerArray

STAMPER = Stamper(1)
STAMPED = [
    (LaserScan, to_scan),
    (Odometry, to_odometry),
    (TFMessage, to_transforms),
    (CompressedImage, to_image),
    (BatteryState, to_battery),
]
CONVERSIONS: list[tuple[type[Message], Callable[[Any], Any]]] = [
    *((cls, lambda message, to=to: to(message, STAMPER)) for cls, to in STAMPED),
    (CameraInfo, to_camera_info),
    (MarkerArray, to_clusters),
    (Path, to_path),
    (DiagnosticArray, to_healths),
    (PoseStamped, to_goal_pose),
    (Twist, to_cmd_vel),
]
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
)


def understood_or_refused(convert: Callable[[Any], Any], message: Message) -> None:
    try:
        convert(message)
    except WireError as error:
        assert str(error)
        assert "\n" not in str(error)


@pytest.mark.parametrize(("cls", "convert"), CONVERSIONS, ids=[cls.__name__ for cls, _ in CONVERSIONS])
@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_any_message_is_understood_or_refused(
    cls: type[Message], convert: Callable[[Any], Any], data: st.DataObject
) -> None:
    understood_or_refused(convert, data.draw(any_message(cls)))


@settings(max_examples=200)
@given(pose=any_message(Pose))
def test_any_pose_as_a_goal_is_near_enough_or_refused(pose: Pose) -> None:
    try:
        goal = to_goal_pose(PoseStamped(Header(frame_id="odom"), pose))
    except WireError:
        return
    assert math.hypot(goal.pose.x_m, goal.pose.y_m) <= FARTHEST_M
    assert abs(goal.pose.theta) <= math.pi


@given(name=st.text(max_size=5), state=st.text(max_size=9) | st.sampled_from(["ok", "failed"]), why=st.text(max_size=5))
def test_any_state_of_ours_is_understood_or_refused(name: str, state: str, why: str) -> None:
    status = DiagnosticStatus(0, name, why, HARDWARE, [KeyValue(STATE, state)])
    understood_or_refused(to_healths, DiagnosticArray(status=[status]))


@pytest.mark.parametrize("convert", [to_detections_detail, to_mission, to_inspection])
@given(data=st.data())
def test_any_text_is_understood_or_refused(convert: Callable[[Any], Any], data: st.DataObject) -> None:
    text = data.draw(st.text(st.characters()) | JSON.map(json.dumps))
    understood_or_refused(convert, String(text))
