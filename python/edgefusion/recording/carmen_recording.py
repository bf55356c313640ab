# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A CARMEN log as a recorded drive, of a robot without a camera."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Iterator, Union

from edgefusion.errors import RefusedError
from edgefusion.recording.carmen import count_scans, read_carmen
from edgefusion.types import Frame, Scan


class CarmenRecording:
    """Scans alone. Raises RefusedError, while they are read, for a log that is not as it should be."""

    frames = 0

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise RefusedError(f"{path}: expected a CARMEN log, found no such file")
        self.path = path

    @property
    def scans(self) -> int:
        """How many scans there are: reads the log once. Raises RefusedError for one that cannot be read."""
        return count_scans(self.path)

    def frame_name(self, index: int) -> str:
        """There are none."""
        raise IndexError(index)

    def messages(self, laser_latency_ns: int = 0, camera_latency_ns: int = 0) -> Iterator[Union[Scan, Frame]]:
        """Its scans, in their order. laser_latency_ns: from capture to the stamp."""
        for scan in read_carmen(self.path):
            yield replace(scan, stamp_ns=scan.stamp_ns - laser_latency_ns)
