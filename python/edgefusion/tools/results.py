# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The folder that `edgefusion detect` and `edgefusion demo` fill: detections.jsonl, pictures, a summary."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Sequence

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.recording.detections import to_json_line
from edgefusion.tools.writing import writing
from edgefusion.types import Detection

DETECTIONS, SUMMARY, PICTURES = "detections.jsonl", "summary.json", ("annotated", "scans")


class ResultsFolder:
    """Writes results as they come: every line is on its way to the disk before the next frame is looked at.

    Nothing is touched before the first result; with `overwrite`, what an earlier run left goes then.
    also: names of files and folders that belong to the results beside those that every run leaves.
    Raises RefusedError where results lie already, and for what cannot be written.
    """

    def __init__(self, path: Path, overwrite: bool = False, also: Sequence[str] = ()) -> None:
        self.path, self._overwrite, self._also = path, overwrite, also
        self._lines: BinaryIO | None = None
        with writing(path):
            present = [path / name for name in (DETECTIONS, SUMMARY, *also) if (path / name).exists()]
        if present and not overwrite:
            raise RefusedError(f"{present[0]}: exists already; --overwrite replaces it, --out takes another")

    def __enter__(self) -> ResultsFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._lines is not None:
            with writing(self.path / DETECTIONS):
                self._lines.close()

    def write_detections(self, frame: int, detections: Sequence[Detection]) -> None:
        """One line per detection of a frame."""
        lines = self._begun()
        with writing(self.path / DETECTIONS):
            lines.writelines(to_json_line(frame, detection) for detection in detections)
            lines.flush()

    def write_image(self, name: str, image: npt.NDArray[np.uint8]) -> Path:
        """A picture below this folder; `name` may have folders and ends with the format."""
        _, data = cv2.imencode(Path(name).suffix, image)
        return self.write_file(name, data.tobytes())

    def write_summary(self, summary: dict[str, Any], name: str = SUMMARY) -> Path:
        """A file of JSON, indented for people."""
        return self.write_file(name, msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n")

    def write_file(self, name: str, content: bytes) -> Path:
        """A file below this folder; `name` may have folders."""
        self._begun()
        path = self.path / name
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        return path

    def _begun(self) -> BinaryIO:
        """The open file of detections, in a folder without the results of an earlier run."""
        if self._lines is None:
            with writing(self.path):
                if self._overwrite and (self.path / DETECTIONS).exists():  # else it is nobody's results
                    self._remove_old()
                self.path.mkdir(parents=True, exist_ok=True)
                self._lines = (self.path / DETECTIONS).open("wb")
        return self._lines

    def _remove_old(self) -> None:
        for path in (self.path / name for name in (SUMMARY, *PICTURES, *self._also)):
            if path.is_dir():
                shutil.rmtree(path)
            elif path.exists():
                path.unlink()


def results_path(asked: Path | None, name: str, overwrite: bool) -> Path:
    """Where results go: as asked, else out/name, which is numbered where it exists and may not be replaced."""
    if asked is not None:
        return asked
    return Path("out") / name if overwrite else free_folder(Path("out"), name)


def free_folder(parent: Path, name: str) -> Path:
    """parent/name, or parent/name-2, -3 ... where that exists: results are never written over unasked."""
    candidate, number = parent / name, 2
    with writing(parent):
        while candidate.exists():
            candidate, number = parent / f"{name}-{number}", number + 1
    return candidate
