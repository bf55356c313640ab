# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What goes into a step of the base's loop, and what comes out of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np
import numpy.typing as npt

from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.navigation.inspection_result import PictureAnswer
from edgefusion.navigation.mission_step import MissionStep
from edgefusion.navigation.safety import Decision
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.robot_device import RobotReport
from edgefusion.types import Detection, Health, Pose2D, Scan, Twist2D


@dataclass(frozen=True)
class Inputs:
    """robot, laser: as of now. detections, pictures: vision's, those that came since the last step; detections_ns: of
    when the newest are, also without one among them. healths: of components beside robot and laser. twist: an
    operator's, who drives instead of the mission."""

    robot: DeviceNews[RobotReport]
    laser: DeviceNews[Scan]
    detections: Sequence[Detection] = ()
    detections_ns: int | None = None
    pictures: Sequence[PictureAnswer] = ()
    healths: Tuple[Health, ...] = ()
    twist: Twist2D | None = None


@dataclass(frozen=True)
class Outputs:
    """command: in what the wire carries; session: of the robot's report that it rests on, None without one.

    enable_motors: in one step, after a resume that finds them off. pose: in `odom` at stamp_ns, None until the robot
    has reported; until then the mission says its state alone. scan: the newest that may be driven by, in the step
    where it came. healths: of all components. robot: its newest report. paused: whether an operator drives.
    way_m [k, 2]: the way ahead in `odom`, in some steps a second; None in the others.
    """

    stamp_ns: int
    command: Twist2D
    session: int | None
    enable_motors: bool
    pose: Pose2D | None
    mission: MissionStep
    decision: Decision
    scan: Scan | None
    healths: Tuple[Health, ...]
    robot: RobotState | None = None
    paused: bool = False
    way_m: npt.NDArray[np.float64] | None = None
