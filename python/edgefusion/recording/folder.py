# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Folder recordings: images/NNNNNN.jpg (or .png), scans.npz, calibration.json or calibration.toml.

scans.npz holds stamp [s] (float64[n]), ranges [m] (float[n, beams]; inf = no return), angle_min and angle_increment
[rad]; also, where known, range_min and range_max [m]. Image N belongs to scan N and has its stamp, or that of
image_stamp [s] (float64[n]).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, Dict, Iterator, Union

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import Frame, Scan

SCANS = "scans.npz"
SUFFIXES = (".jpg", ".jpeg", ".png")
# How a JPEG and a PNG begin and end; decoders fill the rest of a truncated one with grey and only mumble.
FORMATS = ((b"\xff\xd8\xff", b"\xff\xd9"), (b"\x89PNG\r\n\x1a\n", b"IEND\xaeB`\x82"))
TRAILING = 1024
"""Bytes at the end of an image file in which its end may be: cameras pad, and some append notes of their own."""

DIMENSIONS = {
    "stamp": 1, "ranges": 2, "angle_min": 0, "angle_increment": 0, "range_min": 0, "range_max": 0, "image_stamp": 1,
}  # fmt: skip
REQUIRED = ("stamp", "ranges", "angle_min", "angle_increment")
STAMP_MAX_S = 9e9
"""Nanoseconds of more do not fit into 64 bits."""

Arrays = Dict[str, npt.NDArray[np.float64]]


class FolderRecording:
    """A recorded drive. Raises RefusedError, one line that names the file, for what is missing or inconsistent."""

    def __init__(self, path: Path) -> None:
        if not path.is_dir():
            raise RefusedError(f"{path}: expected a folder with images/, scans.npz and a calibration")
        self.path = path
        scans = _read_scans(path / SCANS)
        self._ranges_m = scans["ranges"]
        self._angle_min, self._angle_increment = float(scans["angle_min"]), float(scans["angle_increment"])
        self._range_min_m = float(scans.get("range_min", 0.0))
        self._range_max_m = float(scans.get("range_max", np.inf))
        self._scan_ns = _stamps_ns(scans["stamp"])
        self._frame_ns = _stamps_ns(scans.get("image_stamp", scans["stamp"]))
        self._images = _find_images(path / "images", len(self._frame_ns))

    def __len__(self) -> int:
        """Number of scans, and of frames."""
        return len(self._scan_ns)

    @property
    def frames(self) -> int:
        """How many frames there are."""
        return len(self._frame_ns)

    @property
    def calibration_path(self) -> Path:
        """The calibration beside the data. Raises RefusedError where there is none."""
        for name in ("calibration.toml", "calibration.json"):
            if (self.path / name).is_file():
                return self.path / name
        raise RefusedError(f"{self.path}: expected calibration.toml or calibration.json, found neither")

    def frame_name(self, index: int) -> str:
        """What says which frame it is: the file of its image."""
        return str(self._images[index])

    def scan(self, index: int) -> Scan:
        """Scan number `index`."""
        return Scan(
            stamp_ns=int(self._scan_ns[index]),
            ranges_m=self._ranges_m[index],
            angle_min=self._angle_min,
            angle_increment=self._angle_increment,
            range_min_m=self._range_min_m,
            range_max_m=self._range_max_m,
        )

    def frame(self, index: int) -> Frame:
        """Frame number `index`. Raises RefusedError for an image that is truncated or no image."""
        return Frame(int(self._frame_ns[index]), read_image(self._images[index]))

    def messages(self, laser_latency_ns: int = 0, camera_latency_ns: int = 0) -> Iterator[Union[Scan, Frame]]:
        """Scans and frames in the order of their capture, stamped with it; images are read when their turn comes.

        Latencies: from capture to the stamp that the recording carries.
        """
        scans_ns, frames_ns = self._scan_ns - laser_latency_ns, self._frame_ns - camera_latency_ns
        order = sorted(
            [(stamp, 0, i) for i, stamp in enumerate(scans_ns.tolist())]
            + [(stamp, 1, i) for i, stamp in enumerate(frames_ns.tolist())]
        )
        for stamp_ns, is_frame, index in order:
            message = self.frame(index) if is_frame else self.scan(index)
            yield replace(message, stamp_ns=stamp_ns)


def read_image(path: Path) -> npt.NDArray[np.uint8]:
    """A whole image file as BGR uint8 [height, width, 3]. Raises RefusedError for a truncated or unreadable one."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RefusedError(f"{path}: cannot be read: {error.strerror}") from error
    if _is_truncated(data):
        raise RefusedError(f"{path}: truncated: {len(data)} bytes without the end of an image")
    image = _decode(data)
    if image is None:
        raise RefusedError(f"{path}: expected an image, JPEG or PNG, cannot decode its {len(data)} bytes")
    return image


def _is_truncated(data: bytes) -> bool:
    """Whether it begins like a JPEG or a PNG, whatever it is called, and does not end like one."""
    endings = [ending for magic, ending in FORMATS if data[: len(magic)] == magic[: len(data)]]
    return bool(endings) and not any(ending in data[-TRAILING:] for ending in endings)


def _decode(data: bytes) -> npt.NDArray[np.uint8] | None:
    if not any(data.startswith(magic) for magic, _ in FORMATS):
        return None
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)  # type: ignore[return-value]
    except cv2.error:  # larger than OpenCV permits
        return None


def _read_scans(path: Path) -> Arrays:
    try:
        with path.open("rb") as file:
            scans = _load(file)
    except FileNotFoundError:
        raise RefusedError(f"{path}: missing") from None
    except Exception as error:  # of a damaged archive numpy, zipfile and zlib raise a dozen kinds
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise RefusedError(f"{path}: expected arrays of numbers, each scan of the same length: {reason}") from error
    _check_shapes(path, scans)
    _check_stamps(path, scans)
    _check_angles(path, scans)
    _check_ranges(path, scans)
    return scans


def _load(file: BinaryIO) -> Arrays:
    archive = np.load(file, allow_pickle=False)
    if isinstance(archive, np.ndarray):
        raise ValueError("one array without a name, as np.save writes it, instead of np.savez")
    with archive:
        arrays = {name: archive[name] for name in archive.files if name in DIMENSIONS}
    for name, array in arrays.items():
        if array.dtype.kind not in "iuf":
            raise ValueError(f"{name} is of type {array.dtype}")
    return {name: array.astype(float) for name, array in arrays.items()}


def _check_shapes(path: Path, scans: Arrays) -> None:
    for name in REQUIRED:
        if name not in scans:
            raise RefusedError(f"{path}: expected an array '{name}', found {sorted(scans)}")
    for name, array in scans.items():
        if array.ndim != DIMENSIONS[name]:
            raise RefusedError(f"{path}: {name}: expected {DIMENSIONS[name]} dimensions, got {array.ndim}")
    n = len(scans["stamp"])
    if n == 0:
        raise RefusedError(f"{path}: expected at least one scan, got none")
    for name in ("ranges", "image_stamp"):
        if name in scans and len(scans[name]) != n:
            raise RefusedError(f"{path}: {name}: expected {n} rows, as many as stamps, got {len(scans[name])}")


def _check_stamps(path: Path, scans: Arrays) -> None:
    for name in ("stamp", "image_stamp"):
        if name not in scans:
            continue
        if not np.isfinite(scans[name]).all():
            raise RefusedError(f"{path}: {name}: expected finite values")
        if np.abs(scans[name]).max() > STAMP_MAX_S:
            raise RefusedError(
                f"{path}: {name}: expected seconds, at most {STAMP_MAX_S:g}, got {np.abs(scans[name]).max():g}"
            )
        if (np.diff(_stamps_ns(scans[name])) <= 0).any():
            raise RefusedError(f"{path}: {name}: expected rising stamps")


def _check_angles(path: Path, scans: Arrays) -> None:
    for name in ("angle_min", "angle_increment"):
        if not np.isfinite(scans[name]):
            raise RefusedError(f"{path}: {name}: expected finite values")
    step, beams = float(scans["angle_increment"]), scans["ranges"].shape[1]
    if step == 0:
        raise RefusedError(f"{path}: angle_increment: expected other than 0")
    sweep = abs(step) * (beams - 1)
    if sweep > 2 * np.pi + 1e-6:
        raise RefusedError(
            f"{path}: {beams} beams of {step:.5f} rad sweep {np.degrees(sweep):.0f} degrees: expected at most 360"
        )


def _check_ranges(path: Path, scans: Arrays) -> None:
    nearest_m, farthest_m = float(scans.get("range_min", 0.0)), float(scans.get("range_max", np.inf))
    if not 0 <= nearest_m < np.inf:
        raise RefusedError(f"{path}: range_min: expected 0 m or more, and finite, got {nearest_m:g}")
    if not farthest_m > nearest_m:
        raise RefusedError(f"{path}: range_max: expected above range_min, {nearest_m:g} m, got {farthest_m:g}")
    ranges_m = scans["ranges"]
    if ((ranges_m < 0) & np.isfinite(ranges_m)).any():  # -inf: nearer than range_min, REP 117
        raise RefusedError(f"{path}: ranges: expected 0 m or more, got {ranges_m[np.isfinite(ranges_m)].min():g}")
    usable = np.isfinite(ranges_m) & (ranges_m > 0) & (ranges_m >= nearest_m) & (ranges_m <= farthest_m)
    if not usable.any():
        raise RefusedError(
            f"{path}: ranges: expected a beam between {nearest_m:g} and {farthest_m:g} m, found none in the recording"
        )


def _stamps_ns(seconds: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    return np.round(seconds * 1e9).astype(np.int64)


def _find_images(folder: Path, n: int) -> list[Path]:
    found = {path.stem: path for path in sorted(folder.glob("*")) if path.suffix.lower() in SUFFIXES}
    names = [f"{index:06d}" for index in range(n)]
    missing = [name for name in names if name not in found]
    if missing:
        raise RefusedError(
            f"{folder / missing[0]}.jpg: missing, as {len(missing)} of {n} images are: one per scan is expected"
        )
    extra = sorted(set(found) - set(names))
    if extra:
        raise RefusedError(
            f"{found[extra[0]]}: no scan belongs to it: {n} scans, images 000000 to {names[-1]} expected"
        )
    return [found[name] for name in names]
