# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Reports of the mission as JSON."""

from __future__ import annotations

from typing import Union

import msgspec

from edgefusion.messages.mission_report import InspectionReport, MissionReport
from edgefusion.messages.std_msgs import String


def from_mission(report: Union[MissionReport, InspectionReport]) -> String:
    """For `mission` and `inspection/meta`.

    A report without a goal has no `goal_m` either: readers from before there was one refuse what they do not know, and
    so still read these.
    """
    content = msgspec.to_builtins(report)
    if content.get("goal_m") is None:
        content.pop("goal_m", None)
    return String(msgspec.json.encode(content).decode())
