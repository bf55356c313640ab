# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a robot says, handed to what shows it, each with the stamp of the robot's clock."""

from __future__ import annotations

import time
from typing import Any, Callable, List, Tuple, Union

import rerun as rr

from edgefusion.bus import topics
from edgefusion.bus.client import Robot
from edgefusion.bus.feed import Feed
from edgefusion.bus.topics import Topic
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage, LaserScan
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_camera_info import to_camera_info
from edgefusion.messages.to_clusters import to_clusters
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.messages.to_healths import to_healths
from edgefusion.messages.to_mission import to_mission
from edgefusion.messages.to_odometry import to_odometry
from edgefusion.messages.to_path import to_path
from edgefusion.messages.to_scan import to_scan
from edgefusion.messages.to_transforms import to_transforms
from edgefusion.recording.frame_tree import plain
from edgefusion.tools.view_log import ViewLog

TURN_S = 0.02
_NEWEST = 50
_STAMPER = Stamper()
"""What is shown has the stamp that came beside it."""

Shower = Tuple[Feed[Any], Callable[[Any], None]]


def show(robot: Robot, recording: rr.RecordingStream, seconds: float) -> None:
    """For so long."""
    showers, end_s = _showers(robot, ViewLog(recording)), time.monotonic() + seconds
    while time.monotonic() < end_s:
        for feed, shower in showers:
            for tag, what in feed.take():
                recording.set_time("robot", duration=tag.stamp_ns / 1e9)
                shower(what)
        time.sleep(TURN_S)


def _showers(robot: Robot, log: ViewLog) -> List[Shower]:
    """How things are mounted comes first: what is shown next depends on it."""

    def of(topic: Topic, convert: Callable[[Any], Any], shower: Callable[[Any], None]) -> Shower:
        return Feed(robot.session, robot.name, topic, convert, None, _NEWEST), shower

    return [
        of(topics.TF_STATIC, lambda message: to_transforms(message, _STAMPER), log.mounting),
        of(
            topics.CAMERA_INFO,
            lambda message: (to_camera_info(message), _frame(message)),
            lambda each: log.camera(*each),
        ),
        of(topics.ODOM, lambda message: to_odometry(message, _STAMPER), log.odometry),
        of(topics.SCAN, lambda message: (to_scan(message, _STAMPER), _frame(message)), lambda each: log.scan(*each)),
        of(topics.IMAGE, _jpeg, log.image),
        of(topics.CLUSTERS, to_clusters, log.clusters),
        of(topics.DETECTIONS_DETAIL, to_detections_detail, log.detections),
        of(topics.PATH, to_path, log.path),
        of(topics.MISSION, to_mission, log.mission),
        of(topics.DIAGNOSTICS, to_healths, log.healths),
    ]


def _frame(message: Union[CameraInfo, LaserScan]) -> str:
    """What was recorded of other robots and is played again has frames of other names."""
    return plain(message.header.frame_id)


def _jpeg(message: CompressedImage) -> bytes:
    return bytes(message.data)
