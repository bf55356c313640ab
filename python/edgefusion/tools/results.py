# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The folder that `edgefusion detect` fills: detections.jsonl, annotated images, summary.json."""

from __future__ import annotations

import shutil
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Iterator, Sequence

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.recording.detections import to_json_line
from edgefusion.types import Detection

DETECTIONS, SUMMARY, PICTURES = "detections.jsonl", "summary.json", ("annotated", "scans")


class ResultsFolder:
    """Writes results as they come: every line is on its way to the disk before the next frame is looked at.

    Nothing is touched before the first result; with `overwrite`, what an earlier run left goes then.
    Raises RefusedError where results lie already, and for what cannot be written.
    """

    def __init__(self, path: Path, overwrite: bool = False) -> None:
        self.path, self._overwrite = path, overwrite
        self._lines: BinaryIO | None = None
        with _writing(path):
            present = [path / name for name in (DETECTIONS, SUMMARY) if (path / name).exists()]
        if present and not overwrite:
            raise RefusedError(f"{present[0]}: exists already; --overwrite replaces it, --out takes another")

    def __enter__(self) -> ResultsFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._lines is not None:
            with _writing(self.path / DETECTIONS):
                self._lines.close()

    def write_detections(self, frame: int, detections: Sequence[Detection]) -> None:
        """One line per detection of a frame."""
        lines = self._begun()
        with _writing(self.path / DETECTIONS):
            lines.writelines(to_json_line(frame, detection) for detection in detections)
            lines.flush()

    def write_image(self, name: str, image: npt.NDArray[np.uint8]) -> Path:
        """A picture below this folder; `name` may have folders and ends with the format."""
        self._begun()
        path = self.path / name
        _, data = cv2.imencode(path.suffix, image)
        with _writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data.tobytes())
        return path

    def write_summary(self, summary: dict[str, Any]) -> Path:
        """summary.json, indented for people."""
        self._begun()
        path = self.path / SUMMARY
        with _writing(path):
            path.write_bytes(msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n")
        return path

    def _begun(self) -> BinaryIO:
        """The open file of detections, in a folder without the results of an earlier run."""
        if self._lines is None:
            with _writing(self.path):
                if self._overwrite and (self.path / DETECTIONS).exists():  # else it is nobody's results
                    self._remove_old()
                self.path.mkdir(parents=True, exist_ok=True)
                self._lines = (self.path / DETECTIONS).open("wb")
        return self._lines

    def _remove_old(self) -> None:
        if (self.path / SUMMARY).exists():
            (self.path / SUMMARY).unlink()
        for pictures in PICTURES:
            if (self.path / pictures).exists():
                shutil.rmtree(self.path / pictures)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Raises RefusedError naming the path for what the system refuses."""
    try:
        yield
    except OSError as error:
        raise RefusedError(f"{error.filename or path}: cannot write there: {error.strerror or error}") from error


def results_path(asked: Path | None, name: str, overwrite: bool) -> Path:
    """Where results go: as asked, else out/name, which is numbered where it exists and may not be replaced."""
    if asked is not None:
        return asked
    return Path("out") / name if overwrite else free_folder(Path("out"), name)


def free_folder(parent: Path, name: str) -> Path:
    """parent/name, or parent/name-2, -3 ... where that exists: results are never written over unasked."""
    candidate, number = parent / name, 2
    with _writing(parent):
        while candidate.exists():
            candidate, number = parent / f"{name}-{number}", number + 1
    return candidate
