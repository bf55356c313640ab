# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The page of a drive: the numbers of report.json with the pictures beside them, and what each of them means."""

from __future__ import annotations

from html import escape
from typing import Any, Mapping

from edgefusion.tools.drive import LOOK_NS
from edgefusion.tools.page import Cell, card, headline_figures, page, plot, section, table
from edgefusion.tools.sightings import CONFIRMED_FRAMES, SAME_PLACE_M
from edgefusion.types import UNKNOWN

Report = Mapping[str, Any]

_TOOK = {False: "what simulating and detecting took on this machine", True: "what it took, shown in real time"}
STAGES = {
    "cluster": "project the scan, cluster it, place the boxes",
    "crop": "cut the boxes out and resize them",
    "infer": "the network, all boxes in one batch",
    "vote": "vote and measure",
    "whole frame": "all of it",
}


def html(report: Report) -> str:
    """The whole page."""
    sections = (_first_sightings, _path, _poses, _sightings, _objects, _errors, _stages)
    parts = [_header(report), *(make(report) for make in sections), _footer(report)]
    return page(f"edgefusion demo: {report['world']}", parts)


def _header(report: Report) -> str:
    drive, objects, error = report["drive"], report["objects"], report["distance_error_mm"]
    figures = [
        (f"{objects['found']} of {objects['in_view']}", f"objects found, in {CONFIRMED_FRAMES} frames or more"),
        (f"{objects['named']} of {objects['found']}", "of those named right in most of their frames"),
        (
            _number(error["median"], "{:.0f} mm"),
            f"distance error, median; 95 % below {_number(error['p95'], '{:.0f}')} mm",
        ),
        (str(report["frames"]), f"frames looked at, one every {LOOK_NS / 1e9:g} s or a little later"),
        (f"{drive['duration_s']:.1f} s", f"the drive, {drive['way_m']:.1f} m, in simulated time"),
        (f"{report['took_s']:.0f} s", _TOOK[report["live"]]),
    ]
    return (
        f"<header>\n<h1>edgefusion demo: {escape(report['world'])}</h1>\n"
        "<p>A simulated Pioneer 3-DX with a 2D laser and a camera drove from its start to its goal. Whatever the "
        "laser met and the camera saw was named and measured; here it is beside the truth, which the detector never "
        f"sees.</p>\n{headline_figures(figures)}\n</header>"
    )


def _first_sightings(report: Report) -> str:
    cards = [_card(row) for row in report["sightings"] if row["image"]]
    meaning = (
        f"What was seen in {CONFIRMED_FRAMES} frames within {SAME_PLACE_M:g} m under one name, or rightly without one, "
        "when that was so: the camera's image with the laser's points, the boxes that voted (thin) and the one that "
        "won (thick), and the scan from above with its clusters in the same colours, the robot looking up."
    )
    shown = '<div class="cards">\n' + "\n".join(cards) + "\n</div>" if cards else "<p><b>Nothing was.</b></p>"
    return section("first-sightings", "First sightings", meaning, shown)


def _card(row: Report) -> str:
    truth = "" if row["true_distance_m"] is None else f" (true {row['true_distance_m']:.2f}\u00a0m)"
    right = "" if _right(row) else f", but it is {_what(row)}"
    measured = f"{row['distance_m']:.2f} ± {row['distance_sigma_m']:.2f}\u00a0m"
    caption = f"at {measured}{truth}, {row['stamp_s']:.1f}\u00a0s{right}"
    return card(row["image"], row["scan"], row["label"], caption)


def _path(report: Report) -> str:
    drive = report["drive"]
    meaning = (
        "The world from above: ✓ was found and named right, ✗ was not, what has no mark was never in full view. The "
        "robot follows its odometry, which slips; crosses are where it believes to have seen something. It "
        f"stopped {100 * drive['goal_error_m']:.0f} cm and {drive['goal_error_deg']:.1f}° from its goal; the nearest "
        f"that its middle came to anything is {_number(drive['clearance_m'], '{:.2f} m')}."
    )
    return section("path", "The path", meaning, plot("plots/plan", "plan of the world with the path"))


def _poses(report: Report) -> str:
    meaning = (
        "x, y and theta in the world: where the robot was, where its odometry said it was, and where it had to go."
    )
    return section("poses", "The pose over time", meaning, plot("plots/pose", "x, y and theta over time"))


def _sightings(report: Report) -> str:
    head = ("said", "true", "object", "distance", "true", "IoU", "frames")
    rows = [
        [
            Cell(row["label"], "good" if _right(row) else "soft" if row["label"] == UNKNOWN else "bad"),
            Cell(row["true_label"] or "-"),
            Cell(row["object"], "soft"),
            Cell(f"{row['distance_m']:.3f} ± {row['distance_sigma_m']:.3f} m"),
            Cell(_number(row["true_distance_m"], "{:.3f} m")),
            Cell(_number(row["iou"], "{:.2f}")),
            Cell(str(row["frames"])),
        ]
        for row in report["sightings"]
    ]
    meaning = (
        "Every sighting: what the detector said and what it is; the distance to its nearest surface with one sigma, "
        "when it was confirmed, and the true one; how much of its box and the true box is common to both (IoU); in "
        "how many frames it was seen. A sighting of a wall that has no name is as it should be."
    )
    return section("sightings", "Sightings against the truth", meaning, table(head, rows, texts=3))


def _objects(report: Report) -> str:
    head = ("object", "true", "said mostly", "found in", "named so", "from", "to", "error", "IoU")
    rows = [
        [
            Cell(row["name"], "" if row["counts"] else "soft"),
            Cell(row["label"]),
            Cell(row["said"] or "-", "good" if row["named"] else "bad" if row["said"] else "soft"),
            Cell(f"{row['frames_found']} of {row['frames_in_view']}"),
            Cell(_number(row["said_share"], "{:.0%}")),
            Cell(f"{row['nearest_m']:.1f} m"),
            Cell(f"{row['farthest_m']:.1f} m"),
            Cell(_number(row["distance_error_mm_median"], "{:.0f} mm")),
            Cell(_number(row["iou_median"], "{:.2f}")),
        ]
        for row in report["by_object"]
    ]
    meaning = (
        "Every object that laser and camera saw, over the whole drive. Counted are frames in which it is in full "
        "view: 0.5 to 5 m away, five beams or more on it, most of it in the image, nothing before it. Errors and IoU "
        f"are medians; grey objects were in full view in fewer than {CONFIRMED_FRAMES} frames and do not count."
    )
    return section("objects", "Object by object", meaning, table(head, rows, texts=3))


def _errors(report: Report) -> str:
    error = report["distance_error_mm"]
    meaning = (
        "Every detection of an object in full view: measured minus true distance, over the distance (left) and in "
        f"units of the sigma that the detector gave with it (right). {_number(error['within_2_sigma'], '{:.0%}')} lie "
        "within two sigma, the shaded band; 95 % would be exactly right."
    )
    return section("errors", "Distance errors", meaning, plot("plots/errors", "distance errors"))


def _stages(report: Report) -> str:
    rows = [
        [Cell(name), Cell(STAGES[name], "soft"), Cell(f"{ms['median']:.2f}"), Cell(f"{ms['p95']:.2f}")]
        for name, ms in report["stages_ms"].items()
    ]
    pairing = ", ".join(f"{ending} {count}" for ending, count in report["pairing"].items())
    meaning = (
        f"What the detector took of a frame's time on this machine. Scans and frames were paired by their stamps "
        f"before ({pairing})."
    )
    return section("stages", "Stage times", meaning, table(("stage", "", "median [ms]", "95 % [ms]"), rows, texts=2))


def _footer(report: Report) -> str:
    return (
        f"<footer><p>Made by <code>{escape(report['command'])}</code> with the model {escape(report['model'])}. The "
        'same seed gives the same drive. Beside this page lie <a href="report.json">report.json</a>, the same numbers '
        'for programs, and <a href="detections.jsonl">detections.jsonl</a>, every detection.</p></footer>'
    )


def _right(row: Report) -> bool:
    """Whether a sighting is named as it is; a wall is right without a name."""
    return bool(row["label"] == (row["true_label"] or UNKNOWN))


def _what(row: Report) -> str:
    if row["true_label"] is None:
        return "a wall"
    if row["true_label"] == UNKNOWN:
        return "something without a name"
    return f"{'an' if row['true_label'][0] in 'aeiou' else 'a'} {row['true_label']}"


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else form.format(value)
