# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Reports of the mission from JSON."""

from __future__ import annotations

from edgefusion.messages.json_text import from_text
from edgefusion.messages.mission_report import InspectionReport, MissionReport
from edgefusion.messages.std_msgs import String


def to_mission(message: String) -> MissionReport:
    """Of `mission`. Raises WireError for anything else."""
    return from_text(message, MissionReport, "mission")


def to_inspection(message: String) -> InspectionReport:
    """Of `inspection/meta`. Raises WireError for anything else."""
    return from_text(message, InspectionReport, "inspection/meta")
