# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Folder recordings are read as they are, or refused with the name of the file that is wrong."""

from __future__ import annotations

import io
import shutil
import struct
import zipfile
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.recording.folder import FolderRecording, read_image
from edgefusion.types import Frame, Scan
from scene import FRAMES, write_recording


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


def test_frames_are_named_by_their_files(drive: Path) -> None:
    recording = FolderRecording(drive)
    assert (recording.frames, recording.frame_name(2)) == (FRAMES, str(drive / "images" / "000002.jpg"))


def test_a_beam_without_return_is_free(drive: Path) -> None:
    ranges = np.full((FRAMES, 361), np.inf)
    ranges[1, 0] = 1.0
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


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_bytes_behind_the_end_of_an_image_do_no_harm(tmp_path: Path, suffix: str) -> None:
    picture = np.full((48, 64, 3), 90, np.uint8)
    path = tmp_path / f"padded{suffix}"
    path.write_bytes(cv2.imencode(suffix, picture)[1].tobytes() + b"\0\0written by a camera\n" + bytes(500))
    assert read_image(path).shape == picture.shape


def test_an_image_is_what_it_holds_whatever_it_is_called(tmp_path: Path) -> None:
    data = cv2.imencode(".png", np.full((48, 64, 3), 90, np.uint8))[1].tobytes()
    path = tmp_path / "000000.jpg"
    path.write_bytes(data)
    assert read_image(path).shape == (48, 64, 3)
    path.write_bytes(data[:-3])
    with pytest.raises(RefusedError, match=r"000000.jpg: truncated"):
        read_image(path)


def test_an_image_larger_than_can_be_is_refused(tmp_path: Path) -> None:
    data = bytearray(cv2.imencode(".png", np.zeros((4, 4, 3), np.uint8))[1].tobytes())
    data[16:24] = struct.pack(">II", 1_000_000, 1_000_000)
    data[29:33] = struct.pack(">I", zlib.crc32(bytes(data[12:29])))
    (tmp_path / "000000.png").write_bytes(bytes(data))
    with pytest.raises(RefusedError, match=r"000000.png: expected an image"):
        read_image(tmp_path / "000000.png")


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
        ({"ranges": np.ones((FRAMES, 361), complex)}, "expected arrays of numbers.*ranges is of type complex128"),
        ({"ranges": np.full((FRAMES, 361), -1.5)}, "ranges: expected 0 m or more, got -1.5"),
        ({"ranges": np.full((FRAMES, 361), np.nan)}, "ranges: expected a beam between 0 and inf m, found none"),
        ({"ranges": np.full((FRAMES, 361), 9.0), "range_max": 8.0}, "expected a beam between 0 and 8 m"),
        ({"ranges": np.ones((FRAMES, 0))}, "ranges: expected a beam"),
        ({"range_min": np.nan}, "range_min: expected 0 m or more, and finite, got nan"),
        ({"range_min": np.inf}, "range_min: expected 0 m or more, and finite, got inf"),
        ({"range_min": 2.0, "range_max": 1.0}, "range_max: expected above range_min, 2 m, got 1"),
        ({"range_max": np.nan}, "range_max: expected above range_min, 0 m, got nan"),
        ({"range_max": np.full(FRAMES, 80.0)}, "range_max: expected 0 dimensions, got 1"),
        ({"range_min": np.zeros(1)}, "range_min: expected 0 dimensions, got 1"),
        ({"image_stamp": np.zeros((FRAMES, 2))}, "image_stamp: expected 1 dimensions, got 2"),
        ({"stamp": np.arange(FRAMES) + 1.7e18}, r"stamp: expected seconds, at most 9e\+09, got 1.7e\+18"),
        ({"image_stamp": np.arange(FRAMES) - 1e10}, r"image_stamp: expected seconds, at most 9e\+09"),
        ({"stamp": 1e6 + np.arange(FRAMES) * 2e-10}, "stamp: expected rising stamps"),
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


def test_one_array_without_a_name_is_no_recording(drive: Path) -> None:
    with (drive / "scans.npz").open("wb") as file:
        np.save(file, np.ones(3))
    with pytest.raises(RefusedError, match=r"scans\.npz: .*one array without a name"):
        FolderRecording(drive)


def test_a_flipped_bit_anywhere_is_refused_or_harmless(drive: Path) -> None:
    path = drive / "scans.npz"
    data = path.read_bytes()
    for position in range(0, len(data), 61):
        path.write_bytes(data[:position] + bytes([data[position] ^ 0x10]) + data[position + 1 :])
        try:
            FolderRecording(drive)
        except RefusedError as refused:
            assert str(refused).startswith(f"{path}: ")
            assert "\n" not in str(refused)


def test_a_header_that_promises_more_than_there_is_memory_is_refused(drive: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10**15,)})
    with zipfile.ZipFile(drive / "scans.npz", "w") as archive:
        archive.writestr("stamp.npy", header.getvalue())
    with pytest.raises(RefusedError, match=r"scans\.npz: expected arrays of numbers"):
        FolderRecording(drive)


def test_the_sensors_own_limits_are_the_scans(drive: Path) -> None:
    change_scans(drive, range_min=0.25, range_max=8.0)
    scan = FolderRecording(drive).scan(0)
    assert (scan.range_min_m, scan.range_max_m) == (0.25, 8.0)


def test_latencies_put_messages_into_the_order_of_their_capture(drive: Path) -> None:
    messages = list(FolderRecording(drive).messages(laser_latency_ns=50, camera_latency_ns=10**9))
    assert [type(message) for message in messages[:7]] == [Frame] * 5 + [Scan, Frame]
    assert [message.stamp_ns for message in messages[:2]] == [-(10**9), -8 * 10**8]
    assert messages[5].stamp_ns == -50


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
