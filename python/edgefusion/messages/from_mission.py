# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Reports of the mission as JSON."""

from __future__ import annotations

from typing import Union

from edgefusion.messages.json_text import to_text
from edgefusion.messages.mission_report import InspectionReport, MissionReport
from edgefusion.messages.std_msgs import String


def from_mission(report: Union[MissionReport, InspectionReport]) -> String:
    """For `mission` and `inspection/meta`."""
    return to_text(report)
