# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Everything that is on the bus, below `<robot>/`: the topics, the queries, and who is alive."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Mapping, Type

from edgefusion.messages import Message
from edgefusion.messages.diagnostic_msgs import DiagnosticArray
from edgefusion.messages.geometry_msgs import PoseStamped, Twist
from edgefusion.messages.nav_msgs import Odometry, Path
from edgefusion.messages.sensor_msgs import BatteryState, CameraInfo, CompressedImage, LaserScan
from edgefusion.messages.std_msgs import String
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.vision_msgs import Detection2DArray
from edgefusion.messages.visualization_msgs import MarkerArray


class Direction(str, Enum):
    """OUT: from the robot, for everyone who may read; IN: to the robot, from operators."""

    OUT = "out"
    IN = "in"


class Urgency(str, Enum):
    """Which sample goes first where a line is full."""

    COMMAND = "command"  # at once, alone in its packet
    SOON = "soon"
    USUAL = "usual"
    BULK = "bulk"  # images


@dataclass(frozen=True)
class Topic:
    """name: the key below the robot's, and the name of the ROS topic."""

    name: str
    message: Type[Message]
    direction: Direction = Direction.OUT
    urgency: Urgency = Urgency.USUAL


SCAN = Topic("scan", LaserScan)
ODOM = Topic("odom", Odometry, urgency=Urgency.SOON)
TF = Topic("tf", TFMessage, urgency=Urgency.SOON)
TF_STATIC = Topic("tf_static", TFMessage)
IMAGE = Topic("image/compressed", CompressedImage, urgency=Urgency.BULK)
ANNOTATED = Topic("annotated/compressed", CompressedImage, urgency=Urgency.BULK)
CAMERA_INFO = Topic("camera_info", CameraInfo)
CLUSTERS = Topic("clusters", MarkerArray)
PATH = Topic("path", Path)
BATTERY = Topic("battery", BatteryState)
DIAGNOSTICS = Topic("diagnostics", DiagnosticArray)
MISSION = Topic("mission", String, urgency=Urgency.SOON)
INSPECTION = Topic("inspection/compressed", CompressedImage, urgency=Urgency.BULK)
INSPECTION_META = Topic("inspection/meta", String)
INSPECTION_REQUEST = Topic("inspection/request", String, urgency=Urgency.SOON)
INSPECTION_ANSWER = Topic("inspection/answer", String)
DETECTIONS = Topic("detections", Detection2DArray, urgency=Urgency.SOON)
DETECTIONS_DETAIL = Topic("detections/detail", String, urgency=Urgency.SOON)
GOAL_POSE = Topic("goal_pose", PoseStamped, Direction.IN, Urgency.COMMAND)
CMD_VEL = Topic("cmd_vel", Twist, Direction.IN, Urgency.COMMAND)
HEARTBEAT = Topic("operator/heartbeat", String, Direction.IN, Urgency.COMMAND)

_ALL = (
    SCAN, ODOM, TF, TF_STATIC, IMAGE, ANNOTATED, CAMERA_INFO, CLUSTERS, PATH, BATTERY, DIAGNOSTICS, MISSION, INSPECTION,
    INSPECTION_META, INSPECTION_REQUEST, INSPECTION_ANSWER, DETECTIONS, DETECTIONS_DETAIL, GOAL_POSE, CMD_VEL,
    HEARTBEAT,
)  # fmt: skip
TOPICS: Mapping[str, Topic] = MappingProxyType({topic.name: topic for topic in _ALL})

COMMANDS = tuple(topic for topic in _ALL if topic.direction is Direction.IN)

GOTO, STOP, RESUME, INSPECT = "mission/goto", "stop", "resume", "inspect"
QUERIES = (GOTO, STOP, RESUME, INSPECT)

CLOCK = "clock"
"""A query of the robot's own processes on other computers: what the clock says that everything is stamped with."""

ALIVE = "alive"
"""Below it each component that lives has a token of its name."""


def key_of(robot: str, name: str) -> str:
    """The key of a topic, a query or a token of this robot."""
    return f"{robot}/{name}"
