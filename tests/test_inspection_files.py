# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""An inspection is kept as a picture with a JSON beside it: whole, never over another, and with all that is known."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.navigation.inspection_result import InspectionResult, PictureAnswer
from edgefusion.recording.detections import with_whole_vote
from edgefusion.tools.inspection_files import save_inspection
from edgefusion.types import Pose2D
from mission_scenes import DETECTION

IMAGE = np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8)
RESULT = InspectionResult(
    id="inspection-1", label="Crock Pot", group="appliance", place_m=(3.0, 1.0), pose=Pose2D(1.0, 0.5, 0.25),
    detection=DETECTION, begun_ns=1, stood_ns=2, ended_ns=3, picture=PictureAnswer("inspection-1", 2, IMAGE),
    note="does not face it: goal enclosed",
)  # fmt: skip
WITHOUT = replace(RESULT, picture=None, reason="no answer within 3 s")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_the_picture_and_all_that_is_known_lie_side_by_side(tmp_path: Path) -> None:
    path = save_inspection(tmp_path / "new" / "folder", RESULT, ".png")
    assert names(path.parent) == ["inspection-1-crock-pot.json", "inspection-1-crock-pot.png"]
    record = json.loads(path.read_bytes())
    assert record == {
        "version": 1,
        "id": "inspection-1",
        "label": "Crock Pot",
        "group": "appliance",
        "place_m": [3.0, 1.0],
        "pose": [1.0, 0.5, 0.25],
        "begun_ns": 1,
        "stood_ns": 2,
        "ended_ns": 3,
        "utc": None,
        "picture": {"file": "inspection-1-crock-pot.png", "stamp_ns": 2},
        "reason": "",
        "note": "does not face it: goal enclosed",
        "detection": json.loads(json.dumps(with_whole_vote(DETECTION))),
    }
    assert np.array_equal(cv2.imread(str(path.parent / record["picture"]["file"])), IMAGE)


def test_without_a_picture_the_json_says_why(tmp_path: Path) -> None:
    record = json.loads(save_inspection(tmp_path, WITHOUT).read_bytes())
    assert (record["picture"], record["reason"]) == (None, "no answer within 3 s")
    assert names(tmp_path) == ["inspection-1-crock-pot.json"]


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_a_picture_that_is_encoded_already_stays_as_it_is(tmp_path: Path, suffix: str) -> None:
    content = cv2.imencode(suffix, IMAGE)[1].tobytes()
    path = save_inspection(tmp_path, replace(RESULT, picture=PictureAnswer("inspection-1", 2, content)))
    assert path.with_suffix(suffix).read_bytes() == content


def test_the_time_of_day_is_the_pictures_where_it_is_known(tmp_path: Path) -> None:
    record = json.loads(save_inspection(tmp_path, RESULT, utc_offset_ns=1_700_000_000_123_000_000).read_bytes())
    assert record["utc"] == "2023-11-14T22:13:20.123+00:00"


def test_nothing_is_ever_written_over(tmp_path: Path) -> None:
    kept = {}
    for result in (RESULT, WITHOUT, RESULT, RESULT):
        path = save_inspection(tmp_path, result)
        assert path not in kept
        kept[path] = path.read_bytes()
    (tmp_path / "inspection-1-crock-pot-5.jpg").write_bytes(b"somebody's")
    assert save_inspection(tmp_path, RESULT).name == "inspection-1-crock-pot-6.json"
    assert {path: path.read_bytes() for path in kept} == kept
    assert (tmp_path / "inspection-1-crock-pot-5.jpg").read_bytes() == b"somebody's"
    for path in tmp_path.glob("*.json"):
        picture = json.loads(path.read_bytes())["picture"]
        assert picture is None or picture["file"] == path.with_suffix(".jpg").name


@pytest.mark.parametrize("nth", [1, 2, 3, 4])
def test_when_the_disk_is_full_it_says_so_and_leaves_nothing_half(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, nth: int
) -> None:
    """Whichever of writing and linking, of picture and JSON, fails."""
    calls = []

    def failing(function):
        def call(*args):
            calls.append(function)
            if len(calls) == nth:
                raise OSError(28, "No space left on device")
            return function(*args)

        return call

    monkeypatch.setattr(os, "fsync", failing(os.fsync))
    monkeypatch.setattr(os, "link", failing(os.link))
    with pytest.raises(RefusedError, match=r"cannot write there: No space left on device"):
        save_inspection(tmp_path, RESULT)
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    ("image", "got"),
    [
        (np.zeros((4, 4), np.uint8), r"expected uint8 \[height, width, 3\] or bytes, got uint8 \[4, 4\]"),
        (np.zeros((4, 4, 3)), r"got float64 \[4, 4, 3\]"),
        (np.zeros((0, 4, 3), np.uint8), r"got uint8 \[0, 4, 3\]"),
        ("a picture", r"got str"),
        (b"GIF89a", r"expected the bytes of a JPEG or PNG, got 6 others"),
    ],
)
def test_what_is_no_picture_is_refused_before_anything_is_written(tmp_path: Path, image: object, got: str) -> None:
    with pytest.raises(RefusedError, match=got):
        save_inspection(tmp_path, replace(RESULT, picture=PictureAnswer("inspection-1", 2, image)))
    assert names(tmp_path) == []


def test_a_folder_that_is_a_file_is_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(RefusedError, match=r"file: cannot write there: File exists"):
        save_inspection(tmp_path / "file", RESULT)
