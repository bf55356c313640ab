# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The sections of a report about what was seen: sightings, objects, distances, and what the detector took of time."""

from __future__ import annotations

from edgefusion.tools.page import Cell, Report, card, number, plot, section, table
from edgefusion.tools.sightings import CONFIRMED_FRAMES, SAME_PLACE_M
from edgefusion.types import UNKNOWN

STAGES = {
    "cluster": "project the scan, cluster it, place the boxes",
    "crop": "cut the boxes out and resize them",
    "infer": "the network, all boxes in one batch",
    "vote": "vote and measure",
    "whole frame": "all of it",
}


def first_sightings(report: Report) -> str:
    """Pictures of each."""
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


def sightings(report: Report) -> str:
    """A row for each."""
    head = ("said", "true", "object", "distance", "true", "IoU", "frames")
    rows = [
        [
            Cell(row["label"], "good" if _right(row) else "soft" if row["label"] == UNKNOWN else "bad"),
            Cell(row["true_label"] or "-"),
            Cell(row["object"], "soft"),
            Cell(f"{row['distance_m']:.3f} ± {row['distance_sigma_m']:.3f} m"),
            Cell(number(row["true_distance_m"], "{:.3f} m")),
            Cell(number(row["iou"], "{:.2f}")),
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


def objects(report: Report) -> str:
    """A row for each."""
    head = ("object", "true", "said mostly", "found in", "named so", "from", "to", "error", "IoU")
    rows = [
        [
            Cell(row["name"], "" if row["counts"] else "soft"),
            Cell(row["label"]),
            Cell(row["said"] or "-", "good" if row["named"] else "bad" if row["said"] else "soft"),
            Cell(f"{row['frames_found']} of {row['frames_in_view']}"),
            Cell(number(row["said_share"], "{:.0%}")),
            Cell(f"{row['nearest_m']:.1f} m"),
            Cell(f"{row['farthest_m']:.1f} m"),
            Cell(number(row["distance_error_mm_median"], "{:.0f} mm")),
            Cell(number(row["iou_median"], "{:.2f}")),
        ]
        for row in report["by_object"]
    ]
    meaning = (
        "Every object that laser and camera saw, over the whole drive. Counted are frames in which it is in full "
        "view: 0.5 to 5 m away, five beams or more on it, most of it in the image, nothing before it. Errors and IoU "
        f"are medians; grey objects were in full view in fewer than {CONFIRMED_FRAMES} frames and do not count."
    )
    return section("objects", "Object by object", meaning, table(head, rows, texts=3))


def errors(report: Report) -> str:
    """Of distances."""
    error = report["distance_error_mm"]
    meaning = (
        "Every detection of an object in full view: measured minus true distance, over the distance (left) and in "
        f"units of the sigma that the detector gave with it (right). {number(error['within_2_sigma'], '{:.0%}')} lie "
        "within two sigma, the shaded band; 95 % would be exactly right."
    )
    return section("errors", "Distance errors", meaning, plot("plots/errors", "distance errors"))


def stages(report: Report) -> str:
    """Their times."""
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


def _right(row: Report) -> bool:
    """Whether a sighting is named as it is; a wall is right without a name."""
    return bool(row["label"] == (row["true_label"] or UNKNOWN))


def _what(row: Report) -> str:
    if row["true_label"] is None:
        return "a wall"
    if row["true_label"] == UNKNOWN:
        return "something without a name"
    return f"{'an' if row['true_label'][0] in 'aeiou' else 'a'} {row['true_label']}"
