# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a mission is, in words."""

from __future__ import annotations

import math

from edgefusion.messages.mission_report import InspectionReport, MissionReport, Pose


def mission_in_words(report: MissionReport) -> str:
    """What it does and why, what for, and how far it is."""
    parts = [
        report.state + (f": {report.reason}" if report.reason else ""),
        f"goal {report.goal_id}" if report.goal_id else "",
        "" if report.way_left_m is None else f"{report.way_left_m:.2f} m left",
        "" if report.clearance_m is None else f"{report.clearance_m:.2f} m clear",
        report.note,
        "an operator drives, until resume" if report.paused else "",
    ]
    return ", ".join(part for part in parts if part)


def inspection_in_words(report: InspectionReport) -> str:
    """What was inspected and whether there is a picture."""
    x_m, y_m = report.place_m
    outcome = f"no picture: {report.reason}" if report.picture_ns is None else "has a picture"
    note = f" ({report.note})" if report.note else ""
    return f"inspected {report.label} at x {x_m:.2f} m, y {y_m:.2f} m: {outcome}{note}"


def pose_in_words(pose: Pose | None) -> str:
    """In `odom`."""
    if pose is None:
        return "not known yet"
    x_m, y_m, theta = pose
    return f"x {x_m:.2f} m, y {y_m:.2f} m, {math.degrees(theta):.0f} deg"
