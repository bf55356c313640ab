# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The sections of a report about the drive: the path, what was inspected, the pose, the mission, the safety gate."""

from __future__ import annotations

from html import escape
from typing import Any, Mapping

from edgefusion.config import MissionConfig
from edgefusion.tools.page import Cell, Report, number, picture, plot, section, table

_LOOKS = {"run": "soft", "cap": "", "stop": "", "stop_latched": "bad"}


def path(report: Report) -> str:
    """Over the world's plan."""
    drive = report["drive"]
    meaning = (
        "The world from above, of which the robot knows what its laser has shown it: ✓ was found and named right, ✗ "
        "was not, what has no mark was never in full view. Crosses are where it believes to have seen something; from "
        "where it stopped for a picture a dotted line leads to what it took it of. The nearest that its hull came to "
        f"anything, at the laser's height, is {number(drive['clearance_m'], '{:.2f} m')}."
    )
    return section("path", "The path", meaning, plot("plots/plan", "plan of the world with the path"))


def inspections(report: Report) -> str:
    """The picture and the pose of every stop."""
    rows = report["mission"]["inspections"]
    meaning = (
        "What is of interest is inspected once: when several frames in a row agree about it, the robot stops, turns to "
        f"it, stands for {MissionConfig().stand_s:g} s and has a picture taken. Below each: its pose in that time, "
        "shaded while it stood."
    )
    shown = "\n".join(_inspection(row) for row in rows) or "<p><b>Nothing was.</b></p>"
    return section("inspections", "Inspections", meaning, shown)


def _inspection(row: Mapping[str, Any]) -> str:
    x_m, y_m, degrees = row["pose"]
    stood = "never stood" if row["stood_s"] is None else f"stood from {row['stood_s']:.1f} s"
    caption = (
        f"{row['label']}, score {row['score']:.2f}, {row['distance_m']:.2f} m away, at ({row['place_m'][0]:.2f}, "
        f"{row['place_m'][1]:.2f}); the robot {stood} to {row['ended_s']:.1f} s at ({x_m:.2f}, {y_m:.2f}), "
        f"{degrees:.0f}°. {row['note'] or ''}"
    )
    stop = plot(f"plots/{row['id']}", f"x, y and theta during {row['id']}")
    if not row["picture"]:
        return f"<p><b>{escape(caption)} No picture: {escape(row['reason'])}.</b></p>\n{stop}"
    return f"{picture(row['picture'], row['label'], caption)}\n{stop}"


def poses(report: Report) -> str:
    """Over the whole drive."""
    drive = report["drive"]
    meaning = (
        "x, y and theta in the world: where the robot was, where its odometry said it was, and where it had to go; "
        "shaded while it stood before something. It knows its odometry alone, whose wheels slip: in the end that was "
        f"off by {100 * drive['drift_m']:.1f} cm and {drive['drift_deg']:.1f}°."
    )
    return section("poses", "The pose over time", meaning, plot("plots/pose", "x, y and theta over time"))


def mission(report: Report) -> str:
    """What it did, and when."""
    rows = [
        [
            Cell(event["what"]),
            Cell(f"{event['stamp_s']:.2f} s"),
            Cell("({:.2f}, {:.2f}) m, {:.0f}°".format(*event["pose"])),
        ]
        for event in report["mission"]["events"]
    ]
    meaning = "What the robot's mission did, when, and where it believed to be."
    return section("mission", "The mission", meaning, table(("event", "time", "pose"), rows, texts=1))


def gate(report: Report) -> str:
    """What it found, and what it did to commands."""
    decisions, total = report["gate"]["decisions"], sum(report["gate"]["decisions"].values())
    stopped = decisions["stop"] + decisions["stop_latched"]
    rows = [
        [
            Cell(spell["action"].replace("_", " "), _LOOKS[spell["action"]]),
            Cell(spell["reason"]),
            Cell(f"{spell['from_s']:.2f} s"),
            Cell(f"{spell['until_s'] - spell['from_s']:.2f} s"),
        ]
        for spell in report["gate"]["spells"]
    ]
    meaning = (
        f"Between the mission and the robot, at every one of {total} commands: {decisions['run']} passed as they were, "
        f"{decisions['cap']} were slowed down, {stopped} were made zero. It begins with a stop, until all that a "
        "command rests on has come."
    )
    return section("gate", "The safety gate", meaning, table(("action", "finding", "from", "for"), rows, texts=2))
