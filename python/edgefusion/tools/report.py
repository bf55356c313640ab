# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The page of a drive: the numbers of report.json with the pictures beside them, and what each of them means."""

from __future__ import annotations

from html import escape

from edgefusion.tools import report_drive, report_seen
from edgefusion.tools.page import Report, headline_figures, number, page
from edgefusion.tools.sightings import CONFIRMED_FRAMES

_TOOK = {False: "what simulating and detecting took on this machine", True: "what it took, shown in real time"}
_SECTIONS = (
    report_drive.path,
    report_drive.inspections,
    report_drive.poses,
    report_drive.mission,
    report_drive.gate,
    report_seen.first_sightings,
    report_seen.sightings,
    report_seen.objects,
    report_seen.errors,
    report_seen.stages,
)


def html(report: Report) -> str:
    """The whole page."""
    parts = [_header(report), *(make(report) for make in _SECTIONS), _footer(report)]
    return page(f"edgefusion demo: {report['world']}", parts)


def _header(report: Report) -> str:
    drive, inspections = report["drive"], report["mission"]["inspections"]
    pictures = sum(bool(row["picture"]) for row in inspections)
    goal = f"({drive['goal'][0]:g}, {drive['goal'][1]:g}) m and {drive['goal'][2]:g}°"
    how = f"from its start towards {goal}, with nothing known of the world, and stopped for what it was to inspect"
    return (
        f"<header>\n<h1>edgefusion demo: {escape(report['world'])}</h1>\n"
        f"<p>A simulated Pioneer 3-DX with a 2D laser and a camera drove {how}. Whatever the laser met and the camera "
        "saw was named and measured; here it is beside the truth, which neither the detector nor the navigator ever "
        f"sees.</p>\n{headline_figures(_figures(report, pictures))}\n</header>"
    )


def _figures(report: Report, pictures: int) -> list[tuple[str, str]]:
    drive, objects, error = report["drive"], report["objects"], report["distance_error_mm"]
    inspections = len(report["mission"]["inspections"])
    return [
        (drive["outcome"], drive["reason"] or f"after {drive['duration_s']:.1f} s and {drive['way_m']:.1f} m"),
        (
            f"{100 * drive['odometry_error_m']:.1f} cm, {drive['odometry_error_deg']:.1f}°",
            f"from the goal by its odometry; in truth {100 * drive['true_error_m']:.1f} cm, "
            f"{drive['true_error_deg']:.1f}°",
        ),
        (number(drive["clearance_m"], "{:.2f} m"), "smallest clearance between its hull and anything"),
        (f"{pictures} of {inspections}", "inspections with a picture"),
        (
            f"{objects['found']} of {objects['in_view']}",
            f"objects found, in {CONFIRMED_FRAMES} frames or more; {objects['named']} named right in most",
        ),
        (
            number(error["median"], "{:.0f} mm"),
            f"distance error, median; 95 % below {number(error['p95'], '{:.0f}')} mm",
        ),
        (str(report["frames"]), "frames looked at"),
        (f"{report['took_s']:.0f} s", _TOOK[report["live"]]),
    ]


def _footer(report: Report) -> str:
    return (
        f"<footer><p>Made by <code>{escape(report['command'])}</code> with the model {escape(report['model'])}. The "
        'same seed gives the same drive. Beside this page lie <a href="report.json">report.json</a>, the same numbers '
        'for programs, and <a href="detections.jsonl">detections.jsonl</a>, every detection.</p></footer>'
    )
