# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""vision_msgs 4.x, those that are on the bus."""

from dataclasses import dataclass, field

from edgefusion.messages.geometry_msgs import PoseWithCovariance
from edgefusion.messages.idl import Message, float64, sequence
from edgefusion.messages.std_msgs import Header


@dataclass(frozen=True)
class Point2D(Message, typename="vision_msgs/msg/Point2D"):
    """In pixels."""

    x: float64 = 0.0
    y: float64 = 0.0


@dataclass(frozen=True)
class Pose2D(Message, typename="vision_msgs/msg/Pose2D"):
    """In pixels and radians."""

    position: Point2D = field(default_factory=Point2D)
    theta: float64 = 0.0


@dataclass(frozen=True)
class BoundingBox2D(Message, typename="vision_msgs/msg/BoundingBox2D"):
    """In pixels."""

    center: Pose2D = field(default_factory=Pose2D)
    size_x: float64 = 0.0
    size_y: float64 = 0.0


@dataclass(frozen=True)
class ObjectHypothesis(Message, typename="vision_msgs/msg/ObjectHypothesis"):
    class_id: str = ""
    score: float64 = 0.0


@dataclass(frozen=True)
class ObjectHypothesisWithPose(Message, typename="vision_msgs/msg/ObjectHypothesisWithPose"):
    hypothesis: ObjectHypothesis = field(default_factory=ObjectHypothesis)
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)


@dataclass(frozen=True)
class Detection2D(Message, typename="vision_msgs/msg/Detection2D"):
    """results: the likeliest first. id: of the track, or empty."""

    header: Header = field(default_factory=Header)
    results: sequence[ObjectHypothesisWithPose] = field(default_factory=list)
    bbox: BoundingBox2D = field(default_factory=BoundingBox2D)
    id: str = ""


@dataclass(frozen=True)
class Detection2DArray(Message, typename="vision_msgs/msg/Detection2DArray"):
    header: Header = field(default_factory=Header)
    detections: sequence[Detection2D] = field(default_factory=list)
