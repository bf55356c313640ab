# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Folder recordings are read as they are, or refused with the name of the file that is wrong."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.recording.folder import FolderRecording
from edgefusion.tools.scene import FRAMES, write_recording
from edgefusion.types import Frame, Scan


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    return write_recording(tmp_path_factory.mktemp("recording") / "drive")


@pytest.fixture
def drive(whole: Path, tmp_path: Path) -> Path:
    return shutil.copytree(whole, tmp_path / "drive")


def change_scans(drive: Path, **changes) -> None:
    with np.load(drive / "scans.npz") as scans:
        content = {**dict(scans), **changes}
    np.savez(drive / "scans.npz", **{k: v for k, v in content.items() if v is not None})


def test_messages_come_in_the_order_of_their_stamps(drive: Path) -> None:
    change_scans(drive, image_stamp=np.arange(FRAMES) * 0.2 - 0.05)
    messages = list(FolderRecording(drive).messages())
    assert [message.stamp_ns for message in messages] == sorted(message.stamp_ns for message in messages)
    assert isinstance(messages[0], Frame)
    assert isinstance(messages[1], Scan)
    assert len(messages) == 2 * FRAMES


def test_a_frame_is_found_again_by_its_stamp(drive: Path) -> None:
    recording = FolderRecording(drive)
    assert [recording.frame_index(recording.frame(i).stamp_ns) for i in range(FRAMES)] == list(range(FRAMES))


def test_a_beam_without_return_is_free(drive: Path) -> None:
    ranges = np.full((FRAMES, 361), np.inf)
    change_scans(drive, ranges=ranges, range_max=80.0)
    scan = FolderRecording(drive).scan(0)
    assert np.isposinf(scan.ranges_m).all()
    assert scan.range_max_m == 80.0


def test_a_missing_image_is_named_before_anything_is_done(drive: Path) -> None:
    (drive / "images" / "000003.jpg").unlink()
    with pytest.raises(RefusedError, match=r"images/000003.jpg: missing, as 1 of 6 images are"):
        FolderRecording(drive)


def test_an_image_without_a_scan_is_named(drive: Path) -> None:
    shutil.copy(drive / "images" / "000000.jpg", drive / "images" / "000006.jpg")
    with pytest.raises(RefusedError, match=r"images/000006.jpg: no scan belongs to it"):
        FolderRecording(drive)


@pytest.mark.parametrize("keep", [0, 1, 100, 0.5, -2])
def test_a_truncated_image_is_named_wherever_it_ends(drive: Path, keep: float) -> None:
    path = drive / "images" / "000002.jpg"
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * keep) if isinstance(keep, float) else keep])
    with pytest.raises(RefusedError, match=r"images/000002.jpg: truncated"):
        FolderRecording(drive).frame(2)


def test_a_file_that_is_no_image_is_named(drive: Path) -> None:
    (drive / "images" / "000002.jpg").write_bytes(b"not a picture\xff\xd9")
    with pytest.raises(RefusedError, match=r"images/000002.jpg: expected an image"):
        FolderRecording(drive).frame(2)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"ranges": np.ones((FRAMES - 1, 361))}, "ranges: expected 6 rows, as many as stamps, got 5"),
        ({"ranges": np.ones(361)}, "ranges: expected 2 dimensions, got 1"),
        ({"ranges": None}, "expected an array 'ranges'"),
        ({"stamp": np.array([])}, "expected at least one scan, got none"),
        ({"stamp": np.zeros(FRAMES)}, "stamp: expected rising stamps"),
        ({"stamp": np.full(FRAMES, np.nan)}, "stamp: expected finite values"),
        ({"angle_increment": np.array(0.0)}, "angle_increment: expected other than 0"),
        ({"ranges": np.ones((FRAMES, 1081))}, "1081 beams .* sweep 540 degrees: expected at most 360"),
        ({"ranges": np.array([np.ones(3)] * 5 + [np.ones(2)], object)}, "each scan of the same length"),
        ({"ranges": np.array([["a"] * 3] * 6)}, "expected arrays of numbers"),
    ],
)
def test_scans_that_do_not_fit_are_refused_by_name(drive: Path, changes, expected: str) -> None:
    change_scans(drive, **changes)
    with pytest.raises(RefusedError, match=f"scans.npz: .*{expected}"):
        FolderRecording(drive)


def test_a_damaged_archive_is_named(drive: Path) -> None:
    path = drive / "scans.npz"
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(RefusedError, match=r"scans\.npz"):
        FolderRecording(drive)


def test_a_folder_without_scans_or_calibration_says_which(drive: Path) -> None:
    (drive / "calibration.toml").unlink()
    with pytest.raises(RefusedError, match=r"expected calibration.toml or calibration.json, found neither"):
        _ = FolderRecording(drive).calibration_path
    (drive / "scans.npz").unlink()
    with pytest.raises(RefusedError, match=r"scans.npz: missing"):
        FolderRecording(drive)


def test_the_real_drive_is_read(shared_data: Path) -> None:
    recording = FolderRecording(shared_data / "kitti-drive")
    assert len(recording) == 77
    assert recording.frame(76).image.shape == (375, 1242, 3)
    assert recording.scan(0).ranges_m.shape == (361,)
