# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Folder recordings: images/NNNNNN.jpg (or .png), scans.npz, calibration.json or calibration.toml.

scans.npz holds stamp [s] (float64[n]), ranges [m] (float[n, beams]; inf = no return), angle_min and angle_increment
[rad]; also, where known, range_min and range_max [m]. Image N belongs to scan N and has its stamp, or that of
image_stamp [s] (float64[n]).
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Iterator, Union

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.types import Frame, Scan

SCANS = "scans.npz"
SUFFIXES = (".jpg", ".jpeg", ".png")
# What a whole file ends with; decoders fill the rest of a truncated one with grey and only mumble.
ENDINGS = {".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9", ".png": b"IEND\xaeB`\x82"}


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
    def calibration_path(self) -> Path:
        """The calibration beside the data. Raises RefusedError where there is none."""
        for name in ("calibration.toml", "calibration.json"):
            if (self.path / name).is_file():
                return self.path / name
        raise RefusedError(f"{self.path}: expected calibration.toml or calibration.json, found neither")

    def image_path(self, index: int) -> Path:
        """The file of frame `index`."""
        return self._images[index]

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
        return Frame(int(self._frame_ns[index]), read_image(self.image_path(index)))

    def frame_index(self, stamp_ns: int) -> int:
        """The number of the frame that the recording stamped so."""
        return int(np.searchsorted(self._frame_ns, stamp_ns))

    def messages(self) -> Iterator[Union[Scan, Frame]]:
        """Scans and frames in the order of their stamps; images are read when their turn comes."""
        order = sorted(
            [(stamp, 0, i) for i, stamp in enumerate(self._scan_ns)]
            + [(stamp, 1, i) for i, stamp in enumerate(self._frame_ns)]
        )
        for _, is_frame, index in order:
            yield self.frame(index) if is_frame else self.scan(index)


def read_image(path: Path) -> npt.NDArray[np.uint8]:
    """A whole image file as BGR uint8 [height, width, 3]. Raises RefusedError for a truncated or unreadable one."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RefusedError(f"{path}: cannot be read: {error.strerror}") from error
    if not data.rstrip(b"\0").endswith(ENDINGS.get(path.suffix.lower(), b"")):
        raise RefusedError(f"{path}: truncated: {len(data)} bytes without the end of a {path.suffix[1:]} file")
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
    if image is None:
        raise RefusedError(f"{path}: expected an image, cannot decode its {len(data)} bytes")
    return image  # type: ignore[return-value]


def _read_scans(path: Path) -> dict[str, npt.NDArray[np.float64]]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            scans = {name: np.asarray(archive[name], float) for name in archive.files}
    except FileNotFoundError:
        raise RefusedError(f"{path}: missing") from None
    except (OSError, ValueError, zipfile.BadZipFile, EOFError) as error:
        raise RefusedError(f"{path}: expected arrays of numbers, each scan of the same length: {error}") from error
    _check_scans(path, scans)
    return scans


def _check_scans(path: Path, scans: dict[str, npt.NDArray[np.float64]]) -> None:
    for name, dimensions in (("stamp", 1), ("ranges", 2), ("angle_min", 0), ("angle_increment", 0)):
        if name not in scans:
            raise RefusedError(f"{path}: expected an array '{name}', found {sorted(scans)}")
        if scans[name].ndim != dimensions:
            raise RefusedError(f"{path}: {name}: expected {dimensions} dimensions, got {scans[name].ndim}")
    n = len(scans["stamp"])
    if n == 0:
        raise RefusedError(f"{path}: expected at least one scan, got none")
    for name in ("ranges", "image_stamp"):
        if name in scans and len(scans[name]) != n:
            raise RefusedError(f"{path}: {name}: expected {n} rows, as many as stamps, got {len(scans[name])}")
    for name in ("stamp", "image_stamp", "angle_min", "angle_increment"):
        if name in scans and not np.isfinite(scans[name]).all():
            raise RefusedError(f"{path}: {name}: expected finite values")
    for name in ("stamp", "image_stamp"):
        if name in scans and (np.diff(scans[name]) <= 0).any():
            raise RefusedError(f"{path}: {name}: expected rising stamps")
    if scans["angle_increment"] == 0:
        raise RefusedError(f"{path}: angle_increment: expected other than 0")
    sweep = abs(float(scans["angle_increment"])) * (scans["ranges"].shape[1] - 1)
    if sweep > 2 * np.pi + 1e-6:
        raise RefusedError(
            f"{path}: {scans['ranges'].shape[1]} beams of {float(scans['angle_increment']):.5f} rad "
            f"sweep {np.degrees(sweep):.0f} degrees: expected at most 360"
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
