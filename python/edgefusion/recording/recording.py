# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Recorded drives, whatever the format: one interface, and what opens a path as what it is."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator, Protocol, Union

from edgefusion.errors import RefusedError
from edgefusion.recording.bag import Bag
from edgefusion.recording.bag_recording import BagRecording
from edgefusion.recording.carmen_recording import CarmenRecording
from edgefusion.recording.extras import require
from edgefusion.recording.folder import SCANS, FolderRecording
from edgefusion.recording.topic_choice import ANY, TopicNames
from edgefusion.types import Frame, Scan

_EXPECTED = (
    "a folder with images/ and scans.npz, an MCAP file (.mcap), a bag of ROS 1 (.bag), a bag of ROS 2 (a folder with "
    "metadata.yaml, or .db3), or a CARMEN log (.log, .clf, .gz)"
)
_METADATA = "metadata.yaml"


class Recording(Protocol):
    """Scans and frames that were recorded. Raises RefusedError, while they are read, for data that are damaged."""

    @property
    def path(self) -> Path:
        """The file or folder."""
        ...

    @property
    def frames(self) -> int:
        """How many frames there are."""
        ...

    def frame_name(self, index: int) -> str:
        """What says which frame it is, as the file of its image."""
        ...

    def messages(self, laser_latency_ns: int = 0, camera_latency_ns: int = 0) -> Iterator[Union[Scan, Frame]]:
        """Scans and frames in the order of the recording, stamped with when they were captured; frames are decoded when
        their turn comes. Latencies: from capture to the stamp that the recording carries."""
        ...


def open_recording(path: Path, names: TopicNames = ANY) -> Recording:
    """A recording of any kind; names: the topics of a bag. Raises RefusedError for what is none, or not whole."""
    if (path / SCANS).is_file():
        return FolderRecording(path)
    bag = open_bag(path)
    if bag is not None:
        return BagRecording(bag, names)
    if path.is_file() and path.suffix in (".log", ".clf", ".gz"):
        return CarmenRecording(path)
    if not path.exists():
        raise RefusedError(f"{path}: there is no such thing: expected {_EXPECTED}")
    if path.is_dir():
        return FolderRecording(path)  # says what is missing
    raise RefusedError(f"{path}: expected {_EXPECTED}")


def open_bag(path: Path) -> Bag | None:
    """A bag of any format; None where the path is none. Raises RefusedError for one that cannot be read."""
    mcap = path if path.suffix == ".mcap" and path.is_file() else _only_mcap(path)
    if mcap is not None:
        require("mcap", "record", f"{mcap}: an MCAP file")
        from edgefusion.recording.mcap_bag import McapBag

        return McapBag(mcap)
    if (path.suffix in (".bag", ".db3") and path.is_file()) or (path / _METADATA).is_file():
        require("rosbags", "ros", f"{path}: a bag of ROS")
        from edgefusion.recording.ros_bag import RosBag

        return RosBag(path)
    return None


def _only_mcap(path: Path) -> Path | None:
    """The file in a folder of rosbag2, where it is one alone and of MCAP: rosbags is not needed for it."""
    files = sorted(path.glob("*.mcap")) if (path / _METADATA).is_file() else []
    return files[0] if len(files) == 1 else None
