# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What `mission` and `inspection/meta` hold as JSON. Places in `odom`, stamps by the robot's monotonic clock."""

from __future__ import annotations

from typing import Literal, Optional, Tuple

import msgspec

VERSION: Literal[1] = 1
State = Literal["idle", "driving", "inspecting", "arrived", "blocked", "stopped"]
Place = Tuple[float, float]
Pose = Tuple[float, float, float]
"""x, y [m] and theta [rad]."""


class InspectionReport(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How an inspection ended; `inspection/meta` beside its picture.

    place_m: of the object; pose: of the robot where it stood. picture_ns: when the picture was taken; None: there is
    none, and reason says why. stood_ns: when the robot was at rest, None if it never came to that. note: what else did
    not go as it should.
    """

    version: Literal[1] = VERSION
    id: str
    label: str
    group: str
    score: float
    distance_m: float
    place_m: Place
    pose: Pose
    begun_ns: int
    stood_ns: Optional[int]
    ended_ns: int
    picture_ns: Optional[int]
    reason: str = ""
    note: str = ""


class MissionReport(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the mission is, and in one report each how an inspection ended.

    state, reason, goal_id, note: as in navigation's MissionStep. goal_m: where that goal is, None without one, and from
    older robots. pose: of the robot, None before it has reported. way_left_m, clearance_m: None where there is none.
    paused: whether an operator drives until `resume`.
    """

    version: Literal[1] = VERSION
    stamp_ns: int
    state: State
    reason: str = ""
    goal_id: str = ""
    goal_m: Optional[Place] = None
    pose: Optional[Pose] = None
    way_left_m: Optional[float] = None
    clearance_m: Optional[float] = None
    paused: bool = False
    note: str = ""
    result: Optional[InspectionReport] = None
