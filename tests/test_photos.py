# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The annotated photographs, and the boxes that the benchmark tries in them."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

pytest.importorskip("onnxruntime")
pytest.importorskip("PIL")

from benchmarks import photos
from benchmarks.photos import Picture, Score, candidate, extended, interval, read_subjects, seen

SUBJECTS = read_subjects()


def test_every_annotation_is_a_box_with_a_label_in_a_relative_file() -> None:
    assert len({(each.image, each.box) for each in SUBJECTS}) == len(SUBJECTS) == 58
    for each in SUBJECTS:
        x0, y0, x1, y1 = each.box
        assert 0 <= x0 < x1, each
        assert 0 <= y0 < y1, each
        assert each.label
        assert each.border in ("", "white", "edge")
        assert not Path(each.image).is_absolute()
        assert ".." not in Path(each.image).parts


def test_every_box_lies_in_its_photograph_and_every_label_is_the_models(shared_data: Path) -> None:
    labels = (shared_data / "models" / "imagenet_classes.txt").read_text(encoding="utf-8").splitlines()
    for each in SUBJECTS:
        height, width = cv2.imread(str(shared_data / "images" / each.image)).shape[:2]
        assert each.box[2] <= width, each
        assert each.box[3] <= height, each
        assert labels.count(each.label) == 1


def test_a_candidate_stands_on_the_bottom_edge_and_is_clipped_to_the_image() -> None:
    assert candidate(10, 30, 90, 1.0, 100, 100) == (10, 70, 30, 90)
    assert candidate(10, 30, 90, 2.5, 100, 100) == (10, 40, 30, 90)
    assert candidate(10.5, 30.4, 40, 2.5, 100, 100) == (11, 0, 30, 40)  # half up; 9.75 rows too tall
    assert candidate(-5, 105, 110, 1.0, 100, 100) == (0, 0, 100, 100)


def test_a_candidate_of_which_less_than_a_quarter_is_visible_is_dropped() -> None:
    assert candidate(0, 40, 25, 2.5, 100, 100) == (0, 0, 40, 25)
    assert candidate(0, 40, 24, 2.5, 100, 100) is None
    assert candidate(120, 140, 50, 1.0, 100, 100) is None


def test_the_laser_is_off_by_a_share_of_the_objects_size() -> None:
    assert seen((100, 100, 200, 300), (0, 0, 0)) == (100, 200, 300)
    assert seen((100, 100, 200, 300), (-1, 1, 1)) == pytest.approx((98, 202, 306))


def test_in_an_extended_picture_no_candidate_is_clipped_above() -> None:
    picture = Picture(np.full((60, 80, 3), 50, np.uint8), (10, 20, 50, 55))
    taller = extended(picture, 2.5)
    above = len(taller.pixels) - 60
    assert taller.box == (10, 20 + above, 50, 55 + above)
    assert (taller.pixels == 50).all()
    for errors in ((-1, 1, -1), (-1, 1, 1), (0, 0, 0)):
        left, right, bottom = seen(taller.box, errors)
        assert 0 <= bottom - 2.5 * (right - left)


def test_a_picture_with_room_enough_stays_as_it_is() -> None:
    picture = Picture(np.zeros((200, 80, 3), np.uint8), (10, 150, 50, 190))
    assert extended(picture, 2.5) is picture


def test_the_interval_of_equal_objects_is_a_point_and_that_of_others_holds_the_mean() -> None:
    values = np.column_stack([np.ones(40), np.arange(40.0), np.zeros(40), np.ones(40)])
    found = interval(values)
    assert list(found) == list(Score._fields)
    assert found["iou_clipped"] == [1, 1, 1]
    mean, low, high = found["iou_extended"]
    assert low < mean == 19.5 < high


def test_without_the_photographs_it_says_so_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(photos, "IMAGES", tmp_path / "absent")
    assert photos.main(["--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err.count("\n") == 1
