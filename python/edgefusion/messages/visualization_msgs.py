# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's visualization_msgs from Humble on, those that are on the bus."""

from dataclasses import dataclass, field

from edgefusion.messages.builtin_interfaces import Duration
from edgefusion.messages.geometry_msgs import Point, Pose, Vector3
from edgefusion.messages.idl import Message, float32, int32, sequence
from edgefusion.messages.sensor_msgs import CompressedImage
from edgefusion.messages.std_msgs import ColorRGBA, Header


@dataclass(frozen=True)
class UVCoordinate(Message, typename="visualization_msgs/msg/UVCoordinate"):
    """A place in a texture, from 0 to 1."""

    u: float32 = 0.0
    v: float32 = 0.0


@dataclass(frozen=True)
class MeshFile(Message, typename="visualization_msgs/msg/MeshFile"):
    filename: str = ""
    data: bytes = b""


@dataclass(frozen=True)
class Marker(Message, typename="visualization_msgs/msg/Marker"):
    """Something to draw; ns and id together name it."""

    ARROW = 0
    CUBE = 1
    SPHERE = 2
    CYLINDER = 3
    LINE_STRIP = 4
    LINE_LIST = 5
    CUBE_LIST = 6
    SPHERE_LIST = 7
    POINTS = 8
    TEXT_VIEW_FACING = 9
    MESH_RESOURCE = 10
    TRIANGLE_LIST = 11
    ADD = 0
    MODIFY = 0
    DELETE = 2
    DELETEALL = 3

    header: Header = field(default_factory=Header)
    ns: str = ""
    id: int32 = 0
    type: int32 = 0
    action: int32 = 0
    pose: Pose = field(default_factory=Pose)
    scale: Vector3 = field(default_factory=Vector3)
    color: ColorRGBA = field(default_factory=ColorRGBA)
    lifetime: Duration = field(default_factory=Duration)
    frame_locked: bool = False
    points: sequence[Point] = field(default_factory=list)
    colors: sequence[ColorRGBA] = field(default_factory=list)
    texture_resource: str = ""
    texture: CompressedImage = field(default_factory=CompressedImage)
    uv_coordinates: sequence[UVCoordinate] = field(default_factory=list)
    text: str = ""
    mesh_resource: str = ""
    mesh_file: MeshFile = field(default_factory=MeshFile)
    mesh_use_embedded_materials: bool = False


@dataclass(frozen=True)
class MarkerArray(Message, typename="visualization_msgs/msg/MarkerArray"):
    markers: sequence[Marker] = field(default_factory=list)
