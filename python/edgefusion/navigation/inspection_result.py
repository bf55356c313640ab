# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What goes between the mission and vision at an inspection, and what an inspection leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from edgefusion.errors import RefusedError
from edgefusion.navigation.objects import Point
from edgefusion.types import Detection, Pose2D


@dataclass(frozen=True)
class PictureRequest:
    """Asks vision for a picture of what stands at `place_m` (in `odom`), taken from stamp_ns on, by deadline_ns."""

    id: str
    label: str
    group: str
    place_m: Point
    stamp_ns: int
    deadline_ns: int


@dataclass(frozen=True)
class PictureAnswer:
    """Vision's answer. image: bytes or an array, as whoever keeps it expects, taken at stamp_ns; None: reason says why.

    detection: what vision saw in that image, if it saw the object.
    """

    request_id: str
    stamp_ns: int
    image: Any
    detection: Detection | None = None
    reason: str = ""

    def __post_init__(self) -> None:
        if (self.image is None) != bool(self.reason):
            got = "neither" if self.image is None else "both"
            raise RefusedError(f"picture {self.request_id!r}: expected an image or the reason why not, got {got}")


@dataclass(frozen=True)
class InspectionResult:
    """How an inspection ended.

    place_m: of the object, in `odom`; pose: of the robot where it stood, in `odom`; detection: the picture's, else the
    best of those that the object was found by. begun_ns: told to stop; stood_ns: at rest, None if it never came to
    that. picture: None, and reason says why; note: what else did not go as it should.
    """

    id: str
    label: str
    group: str
    place_m: Point
    pose: Pose2D
    detection: Detection
    begun_ns: int
    stood_ns: int | None
    ended_ns: int
    picture: PictureAnswer | None
    reason: str = ""
    note: str = ""
