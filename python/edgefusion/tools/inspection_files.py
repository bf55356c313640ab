# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Keeps inspections: the picture, and beside it a file of JSON with everything that is known about it."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Literal, NamedTuple

import msgspec
import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.navigation.inspection_result import InspectionResult
from edgefusion.recording.detections import with_whole_vote
from edgefusion.tools.writing import writing

ENCODED = {b"\xff\xd8\xff": ".jpg", b"\x89PNG\r\n\x1a\n": ".png"}
"""How a picture that is encoded already begins."""


class Picture(NamedTuple):
    """Encoded, as a file of this suffix holds it."""

    suffix: str
    content: bytes


def save_inspection(
    folder: Path,
    result: InspectionResult,
    suffix: Literal[".jpg", ".png"] = ".jpg",
    utc_offset_ns: int | None = None,
) -> Path:
    """Writes a result into a folder, which is made where there is none; returns the path of the JSON.

    Each file appears whole or not at all, the JSON last, and none replaces another: the names are numbered where they
    exist. The picture is BGR uint8 [height, width, 3], which is encoded as `suffix`, or the bytes of a JPEG or PNG,
    which stay as they are. utc_offset_ns: what makes nanoseconds of UTC of the stamps; None: the JSON has the stamps
    alone. Raises RefusedError for any other picture, and for what the system does not let it write.
    """
    picture = None if result.picture is None else _encoded(result.picture.image, suffix)
    stem = re.sub(r"[^a-z0-9]+", "-", f"{result.id} {result.label}".lower()).strip("-")
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        path, number = folder / f"{stem}.json", 1
        while True:
            with suppress(FileExistsError):
                _write(path, result, picture, utc_offset_ns)
                return path
            number += 1
            path = folder / f"{stem}-{number}.json"


def _write(path: Path, result: InspectionResult, picture: Picture | None, utc_offset_ns: int | None) -> None:
    """The picture and the JSON, or neither. Raises FileExistsError where either exists."""
    if picture is None:
        _write_new(path, _json(result, None, utc_offset_ns))
        return
    image = path.with_suffix(picture.suffix)
    _write_new(image, picture.content)
    try:
        _write_new(path, _json(result, image.name, utc_offset_ns))
    except OSError:
        image.unlink()
        raise


def _write_new(path: Path, content: bytes) -> None:
    """A file that appears with all of its content. Raises FileExistsError where there is one."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.link(temporary, path)  # a rename would replace what is there
    finally:
        with suppress(FileNotFoundError):
            temporary.unlink()


def _encoded(image: Any, suffix: str) -> Picture:
    """Raises RefusedError for what is no picture."""
    if isinstance(image, bytes):
        found = next((ending for start, ending in ENCODED.items() if image.startswith(start)), None)
        if found is None:
            raise RefusedError(f"picture: expected the bytes of a JPEG or PNG, got {len(image)} others")
        return Picture(found, image)
    if not (
        isinstance(image, np.ndarray)
        and image.dtype == np.uint8
        and image.ndim == 3
        and image.shape[2] == 3
        and image.size
    ):
        got = f"{image.dtype} {list(image.shape)}" if isinstance(image, np.ndarray) else type(image).__name__
        raise RefusedError(f"picture: expected uint8 [height, width, 3] or bytes, got {got}")
    import cv2  # not for who has encoded pictures alone: a base that drives is not to wait for it

    return Picture(suffix, cv2.imencode(suffix, image)[1].tobytes())


def _json(result: InspectionResult, image: str | None, utc_offset_ns: int | None) -> bytes:
    """Stamps, units and frames as in `InspectionResult`. utc: of the picture, else of the end."""
    stamp_ns = result.ended_ns if result.picture is None else result.picture.stamp_ns
    pose = result.pose
    record = {
        "version": 1,
        "id": result.id,
        "label": result.label,
        "group": result.group,
        "place_m": result.place_m,
        "pose": [pose.x_m, pose.y_m, pose.theta],
        "begun_ns": result.begun_ns,
        "stood_ns": result.stood_ns,
        "ended_ns": result.ended_ns,
        "utc": None if utc_offset_ns is None else _utc(stamp_ns + utc_offset_ns),
        "picture": None if image is None else {"file": image, "stamp_ns": stamp_ns},
        "reason": result.reason,
        "note": result.note,
        "detection": with_whole_vote(result.detection),
    }
    return msgspec.json.format(msgspec.json.encode(record), indent=2) + b"\n"


def _utc(utc_ns: int) -> str:
    return datetime.fromtimestamp(utc_ns / 1e9, timezone.utc).isoformat(timespec="milliseconds")
