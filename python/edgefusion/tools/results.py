# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The folder that `edgefusion detect` fills: detections.jsonl, annotated images, summary.json."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any, Sequence

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.recording.detections import to_json_line
from edgefusion.types import Detection

DETECTIONS = "detections.jsonl"


class ResultsFolder:
    """Writes results as they come: every line is on its way to the disk before the next frame is looked at."""

    def __init__(self, path: Path, overwrite: bool = False) -> None:
        self.path = path
        if (path / DETECTIONS).exists() and not overwrite:
            raise RefusedError(f"{path / DETECTIONS}: exists already; --overwrite replaces it, --out takes another")
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lines = (path / DETECTIONS).open("wb")
        except OSError as error:
            raise RefusedError(f"{path}: cannot write there: {error.strerror}") from error

    def __enter__(self) -> ResultsFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lines.close()

    def write_detections(self, frame: int, detections: Sequence[Detection]) -> None:
        """One line per detection of a frame."""
        self._lines.writelines(to_json_line(frame, detection) for detection in detections)
        self._lines.flush()

    def write_image(self, name: str, image: npt.NDArray[np.uint8]) -> Path:
        """A picture below this folder; `name` may have folders and ends with the format."""
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        _, data = cv2.imencode(path.suffix, image)
        path.write_bytes(data.tobytes())
        return path

    def write_summary(self, summary: dict[str, Any]) -> Path:
        """summary.json, indented for people."""
        path = self.path / "summary.json"
        path.write_bytes(msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n")
        return path


def free_folder(parent: Path, name: str) -> Path:
    """parent/name, or parent/name-2, -3 ... where that exists: results are never written over unasked."""
    candidate, number = parent / name, 2
    while candidate.exists():
        candidate, number = parent / f"{name}-{number}", number + 1
    return candidate
