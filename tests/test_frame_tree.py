# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where frames are follows from the transforms of a bag, and only from what stands still."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from bag_scenes import OFFSET_NS, STAMPER, Sample, write_ours
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.transform import FrameTransform
from edgefusion.recording.frame_tree import FrameTree, read_tree
from edgefusion.recording.mcap_bag import McapBag

Matrix = npt.NDArray[np.float64]


def at(x: float, y: float = 0.0, turn: float = 0.0) -> Matrix:
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]], float)


def tree(*transforms: tuple[str, str, Matrix]) -> FrameTree:
    found = FrameTree()
    for transform in transforms:
        found.add(FrameTransform(*transform))
    return found


def test_a_transform_goes_up_one_branch_and_down_another() -> None:
    found = tree(
        ("base_link", "mast", at(1)), ("mast", "camera", at(0, 2, np.pi / 2)), ("/base_link", "/laser", at(3, 0))
    )
    point = found.transform("camera", "laser") @ (1, 0, 0, 1)  # (4, 0) of base_link, (3, 0) of mast
    assert point == pytest.approx([-2, -3, 0, 1])
    assert found.transform("laser", "camera") == pytest.approx(np.linalg.inv(found.transform("camera", "laser")))
    assert found.transform("laser", "laser") == pytest.approx(np.eye(4))
    assert found.frames == ["base_link", "camera", "laser", "mast"]


def test_frames_that_nothing_connects_have_no_transform() -> None:
    found = tree(("base_link", "laser", at(1)), ("mast", "camera", at(1)))
    assert found.transform("camera", "laser") is None
    assert found.transform("laser", "elsewhere") is None


def test_of_a_frame_that_moves_nothing_is_known() -> None:
    found = tree(("base", "head", at(1)), ("base", "head", at(1 + 1e-9)))
    assert found.transform("base", "head") is not None
    found = tree(("base", "head", at(1)), ("base", "head", at(1.01)), ("base", "head", at(1.01)))
    assert found.transform("base", "head") is None


def test_a_circle_of_frames_ends() -> None:
    found = tree(("a", "b", at(1)), ("b", "c", at(1)), ("c", "a", at(1)))
    assert found.transform("elsewhere", "a") is None


def test_what_stands_still_is_also_found_in_tf_and_the_robots_way_is_not(tmp_path: Path) -> None:
    mounted = FrameTransform("base_link", "laser", at(0.2))
    messages = [
        Sample("/tf", from_transforms(i, [FrameTransform("odom", "base_link", at(i)), mounted], STAMPER), OFFSET_NS + i)
        for i in range(3)
    ]
    found = read_tree(McapBag(write_ours(tmp_path / "a.mcap", iter(messages))))
    assert found.transform("base_link", "laser") == pytest.approx(at(0.2))
    assert found.transform("odom", "laser") is None
