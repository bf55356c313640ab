# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The figures of an evaluation are what they say."""

from __future__ import annotations

import pytest

from edgefusion.tools.evaluation import Outcome
from edgefusion.tools.figures import figures, precision, summary
from edgefusion.tools.measure import Claim, Seen


def seen(**change) -> Seen:
    """A washer 2 m ahead, alone, found, named and measured without error."""
    usual = {
        "world": "w", "frame": 0, "kind": "washer", "label": "washer", "range_m": 2.0, "beams": 20, "in_view": 1.0,
        "occlusion": 0.0, "clearance_m": 1.0, "found": True, "said": "washer", "named": True, "iou": 0.9,
        "height_error": 0.0, "width_error_px": 0.0, "distance_error_m": 0.0, "sigma_m": 0.01,
    }  # fmt: skip
    return Seen(**{**usual, **change})


MISSED = {"found": False, "said": "", "named": False, "iou": None, "height_error": None, "width_error_px": None,
          "distance_error_m": None, "sigma_m": None}  # fmt: skip


def test_recall_is_of_all_and_everything_else_of_what_was_found() -> None:
    row = figures([seen(), seen(named=False, iou=0.5), seen(**MISSED), seen(**MISSED)])
    assert row["objects"] == 4
    assert row["recall"] == 0.5
    assert row["label_accuracy"] == 0.5
    assert row["mean_iou"] == pytest.approx(0.7)


def test_errors_are_absolute_where_they_are_percentiles_and_signed_where_they_are_a_bias() -> None:
    row = figures([seen(distance_error_m=e, height_error=e, width_error_px=100 * e) for e in (-0.02, 0.02, 0.02, 0.02)])
    assert row["distance_bias_mm"] == pytest.approx(10)
    assert row["distance_p95_mm"] == pytest.approx(20)
    assert row["height_error_median"] == pytest.approx(0.02)
    assert row["width_error_px_p95"] == pytest.approx(2)


def test_the_truth_within_two_sigma_counts_both_sides() -> None:
    errors = (-0.021, -0.02, 0.0, 0.02, 0.021)
    assert figures([seen(distance_error_m=e, sigma_m=0.01) for e in errors])["within_2_sigma"] == pytest.approx(0.6)


def test_nothing_has_no_figures() -> None:
    row = figures([])
    assert row.pop("objects") == 0
    assert set(row.values()) == {None}
    assert figures([seen(**MISSED)])["mean_iou"] is None


@pytest.mark.parametrize(
    ("change", "counts", "free", "touching"),
    [
        ({}, True, True, False),
        ({"clearance_m": 0.59}, True, False, False),
        ({"clearance_m": 0.05}, True, False, True),
        ({"range_m": 0.49}, False, False, False),
        ({"range_m": 5.01}, False, False, False),
        ({"beams": 4}, False, False, False),
        ({"in_view": 0.4}, False, False, False),
        ({"occlusion": 0.05, "clearance_m": 0.05}, False, False, False),
    ],
)
def test_the_aims_are_about_what_is_near_wide_in_view_and_not_hidden(change, counts, free, touching) -> None:
    each = seen(**change)
    assert (each.counts, each.free, each.touching) == (counts, free, touching)


def test_precision_is_the_share_of_detections_that_are_an_objects() -> None:
    claims = [Claim(True, True, True), Claim(True, True, False), Claim(False, False, False), Claim(True, False, False)]
    assert precision(claims) == {"detections": 4, "precision": 0.75, "named": 2, "named_right": 0.5}


def test_a_summary_parts_free_from_touching_and_goes_by_kind_and_range() -> None:
    rows = [seen(), seen(kind="safe", range_m=4.5), seen(clearance_m=0.0), seen(occlusion=0.5)]
    report = summary(Outcome(rows, []))
    assert [report[group]["objects"] for group in ("all", "free", "touching")] == [4, 2, 1]
    assert {kind: row["objects"] for kind, row in report["by_kind"].items()} == {"safe": 1, "washer": 1}
    assert {name: row["objects"] for name, row in report["by_range"].items() if row["objects"]} == {
        "2-3 m": 1,
        "4-5 m": 1,
    }
