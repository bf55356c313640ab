# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is shown of each kind of message, as entities of Rerun."""

from __future__ import annotations

import re
from typing import Dict, Sequence, Set

import numpy as np
import numpy.typing as npt
import rerun as rr

from edgefusion.messages.frames import CAMERA_OPTICAL, LASER
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.mission_report import MissionReport
from edgefusion.messages.to_detections_detail import Detections
from edgefusion.messages.to_healths import Report
from edgefusion.messages.to_odometry import Reckoning
from edgefusion.messages.to_transforms import StampedTransform
from edgefusion.messages.transform import FrameTransform
from edgefusion.recording.frame_tree import plain
from edgefusion.tools.view_projection import camera_from_laser, pixels, points, to_base
from edgefusion.types import Pose2D, Scan

FARTHEST_M = 8.0
"""What is farther than this is all of one colour in the image."""

_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_SIZE_M, _POINT_M, _WAY_M = (0.2, 0.2, 0.1), 0.03, 0.02
_ORANGE, _GREY, _GREEN = (245, 130, 30), (150, 150, 150), (60, 190, 100)
"""Seen on black and on white."""


class ViewLog:
    """Keeps how the devices are mounted, by which the scan is put over the image."""

    def __init__(self, recording: rr.RecordingStream) -> None:
        self._recording = recording
        self._frames: Dict[str, FrameTransform] = {}
        self._camera: Intrinsics | None = None
        self._plotted: Set[str] = set()
        self._laser_frame, self._camera_frame = LASER, CAMERA_OPTICAL

    def mounting(self, transforms: Sequence[StampedTransform]) -> None:
        """Where the laser and the camera are on the robot."""
        for transform in (each.transform for each in transforms):
            parent, child = plain(transform.parent), plain(transform.child)
            self._frames[child] = FrameTransform(parent, child, transform.T_parent_child)
        T = to_base(self._frames, self._laser_frame)
        if T is not None:
            self._log("odom/robot/laser", rr.Transform3D(translation=T[:3, 3], mat3x3=T[:3, :3]))

    def camera(self, camera: Intrinsics, frame: str) -> None:
        """What the camera makes of what it sees. frame: where it is; empty: the usual one."""
        self._camera, self._camera_frame = camera, frame or CAMERA_OPTICAL

    def odometry(self, reckoning: Reckoning) -> None:
        """The robot, where it is."""
        T = reckoning.pose.matrix()
        self._log("odom/robot", rr.Transform3D(translation=T[:3, 3], mat3x3=T[:3, :3]))
        self._log("odom/robot/body", rr.Boxes3D(half_sizes=[_SIZE_M], colors=[_ORANGE]))
        self._log("odom/robot/ahead", rr.Arrows3D(vectors=[(0.5, 0, 0)], colors=[_ORANGE]))

    def scan(self, scan: Scan, frame: str) -> None:
        """From above, and over the image. frame: where the laser is; empty: the usual one."""
        self._laser_frame = frame or LASER
        self._log("odom/robot/laser/scan", rr.Points3D(points(scan), radii=_POINT_M / 2, colors=[_GREY]))
        T_camera_laser = camera_from_laser(self._frames, self._laser_frame, self._camera_frame)
        if self._camera is not None and T_camera_laser is not None:
            seen = pixels(scan, self._camera, T_camera_laser)
            self._log("camera/scan", rr.Points2D(seen.uv, radii=2.0, colors=_colours(seen.ranges_m), draw_order=20))

    def image(self, data: bytes) -> None:
        """As the camera took it, a JPEG or PNG."""
        media_type = "image/png" if data.startswith(b"\x89PNG") else "image/jpeg"
        self._log("camera/image", rr.EncodedImage(contents=data, media_type=media_type))

    def clusters(self, clusters: Sequence[npt.NDArray[np.float64]]) -> None:
        """Each in its colour."""
        places = [np.pad(each, ((0, 0), (0, 1))) for each in clusters]
        numbers = np.repeat(np.arange(len(places)) + 1, [len(each) for each in places])
        shown = np.concatenate([np.empty((0, 3)), *places])
        self._log("odom/robot/laser/clusters", rr.Points3D(shown, radii=_POINT_M, class_ids=numbers))

    def detections(self, frame: Detections) -> None:
        """Boxes with labels, and how far each label's nearest object is."""
        each = frame.detections
        boxes = np.array([one.box for one in each], float).reshape(-1, 4)
        labels = [f"{one.label} {one.distance_m:.2f} m" for one in each]
        self._log(
            "camera/boxes",
            rr.Boxes2D(array=boxes, array_format=rr.Box2DFormat.XYXY, labels=labels, show_labels=True, draw_order=30),
        )
        for one in sorted(each, key=lambda detection: -detection.distance_m):
            self._plot(f"distance_m/{_name(one.label)}", one.label, one.distance_m)

    def path(self, poses: Sequence[Pose2D]) -> None:
        """The way ahead, which may end before the goal."""
        way = [(pose.x_m, pose.y_m, 0.0) for pose in poses]
        self._log("odom/path", rr.LineStrips3D([way] if way else [], radii=_WAY_M, colors=[_GREEN]))

    def mission(self, report: MissionReport) -> None:
        """The goal that is driven to, or will be when the robot drives on."""
        goal = [] if report.goal_m is None else [(*report.goal_m, 0.0)]
        self._log("odom/goal", rr.Points3D(goal, radii=0.1, colors=[_GREEN], labels=["goal"] if goal else []))

    def healths(self, reports: Sequence[Report]) -> None:
        """States as a log, and the figures that are numbers: times, and others."""
        for report in reports:
            component, state, reason = report.health.component, report.health.state.value, report.health.reason
            self._log(f"states/{_name(component)}", rr.TextLog(f"{component} {state}: {reason}".rstrip(": ")))
            for name, value in report.figures.items():
                if _NUMBER.fullmatch(value):
                    folder = "times_ms" if name.endswith("[ms]") else "figures"  # counts would flatten the times
                    plain_name = name.replace(" [ms]", "")
                    self._plot(f"{folder}/{_name(component)}/{_name(name)}", f"{component} {plain_name}", float(value))

    def _plot(self, path: str, name: str, value: float) -> None:
        if path not in self._plotted:
            self._plotted.add(path)
            self._recording.log(path, rr.SeriesLines(names=[name]), static=True)
        self._log(path, rr.Scalars(value))

    def _log(self, path: str, what: rr.AsComponents) -> None:
        self._recording.log(path, what)


def _name(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]+", "_", text)


def _colours(ranges_m: npt.NDArray[np.float64]) -> npt.NDArray[np.uint8]:
    """From red, near, to blue, far; uint8 [n, 3]."""
    far = np.clip(ranges_m / FARTHEST_M, 0, 1)
    return np.stack([255 * (1 - far), 255 * (1 - abs(2 * far - 1)), 255 * far], axis=1).astype(np.uint8)
