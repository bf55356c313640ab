# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Every field of a line of detections.jsonl is what the detection holds."""

from __future__ import annotations

import json

import numpy as np

from edgefusion.recording.detections import to_json_line, with_whole_vote
from edgefusion.types import ClassScore, Cluster, Detection, Pose2D, Vote

SCORES = tuple(ClassScore(i, f"label {i}", round(0.5 - 0.05 * i, 3)) for i in range(7))
DETECTION = Detection(
    stamp_ns=123456789012345678,
    class_index=0,
    label="label 0",
    group="first",
    score=0.5,
    margin=0.05,
    box=(1, 2, 30, 40),
    distance_m=1.2345678,
    distance_sigma_m=0.0123456,
    bearing=-0.25,
    position_m=(1.1, -0.3),
    vote=Vote(SCORES, box_index=1, margin=0.05, top5=(SCORES[1:6], SCORES[:5])),
    boxes=((1, 2, 30, 20), (1, 2, 30, 40)),
    cluster=Cluster(np.arange(4), 1.2, -0.25, 0.4),
    scan_frame_dt_ns=-25_000_000,
    motion=Pose2D(0.1, 0.2, 0.3),
    motion_px=4.5,
)


def plain(scores) -> list[dict]:
    return [{"label": s.label, "class_index": s.class_index, "score": s.score} for s in scores]


def test_a_line_holds_every_field_of_its_detection() -> None:
    line = to_json_line(17, DETECTION)
    assert line.endswith(b"}\n")
    assert json.loads(line) == {
        "frame": 17,
        "stamp_ns": 123456789012345678,
        "label": "label 0",
        "group": "first",
        "class_index": 0,
        "score": 0.5,
        "margin": 0.05,
        "box": [1, 2, 30, 40],
        "distance_m": 1.23457,
        "distance_sigma_m": 0.01235,
        "bearing": -0.25,
        "position_m": [1.1, -0.3],
        "scan_frame_dt_ns": -25_000_000,
        "motion": [0.1, 0.2, 0.3],
        "motion_px": 4.5,
        "runners_up": plain(SCORES[1:5]),
        "boxes": [[1, 2, 30, 20], [1, 2, 30, 40]],
        "top5": [plain(SCORES[1:6]), plain(SCORES[:5])],
    }


def test_the_winner_is_no_runner_up() -> None:
    runners_up = json.loads(to_json_line(0, DETECTION))["runners_up"]
    assert DETECTION.vote.winner.label not in [each["label"] for each in runners_up]


def test_the_whole_vote_is_kept_where_it_is_asked_for() -> None:
    record = json.loads(json.dumps(with_whole_vote(DETECTION)))
    line = json.loads(to_json_line(0, DETECTION))
    assert record.pop("vote") == {
        "ranking": plain(SCORES),
        "box_index": 1,
        "margin": 0.05,
        "top5": [plain(SCORES[1:6]), plain(SCORES[:5])],
    }
    assert record == {name: line[name] for name in line if name not in ("frame", "runners_up", "top5")}
