# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the mission: what is inspected on the way to the goals, and how."""

from __future__ import annotations

import math
import sys
from typing import Optional, Tuple

import msgspec

from edgefusion.config.strict import FilePath, Seconds, Share, UpTo10, UpTo100, check_fields

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Name = Annotated[str, msgspec.Meta(min_length=1)]


class MissionConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Objects of interest and the stop at each. The object and the 10 s are those of the paper's experiment."""

    interest: Tuple[Name, ...] = ("oscilloscope",)
    """Labels, or groups of labels, that are inspected; none: the robot only drives."""
    min_score: Share = 0.3
    """Weaker detections are not inspected. [share]"""
    max_distance_m: UpTo100 = 4.0
    """Objects that are farther away are not inspected, from where they are seen."""
    confirm_frames: Annotated[int, msgspec.Meta(ge=1, le=100)] = 3
    """An object is believed in once it was seen in so many frames. [frames]"""
    confirm_s: Seconds = 2.0
    """All confirm_frames are within so long."""
    same_place_m: UpTo10 = 0.6
    """Objects of one label or group that are no farther apart are one object, and inspected once."""
    max_detection_age_s: Seconds = 2.0
    """Detections that are older when they arrive are dropped: the poses of that time are forgotten."""
    facing_tolerance: Annotated[float, msgspec.Meta(gt=0, le=math.pi)] = math.radians(5)
    """How exactly the robot turns to the object. [rad]"""
    facing_s: Seconds = 15.0
    """When it gives up turning."""
    stand_s: Seconds = 10.0
    """How long it stands before the object."""
    picture_s: Seconds = 3.0
    """How long it waits for the picture."""
    last_look_s: Annotated[float, msgspec.Meta(ge=0, le=60)] = 1.5
    """At the last goal it looks for so long before it says that it has arrived: detections are late, and an object that
    only now comes into view is still inspected."""
    inspections: Optional[FilePath] = None
    """The folder where pictures of inspections are kept, each with what is known of it. Left out: nowhere."""

    def __post_init__(self) -> None:
        check_fields(self)
