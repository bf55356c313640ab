# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The calibration that belongs to a recording."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from edgefusion.errors import RefusedError
from edgefusion.perception.calibration import Calibration, load_calibration
from edgefusion.recording.bag_geometry import read_geometry
from edgefusion.recording.bag_recording import BagRecording
from edgefusion.recording.folder import FolderRecording
from edgefusion.recording.recording import Recording


class Known(NamedTuple):
    """source: where the calibration is from, for people."""

    calibration: Calibration
    source: str


def find_calibration(recording: Recording, path: Path | None) -> Known:
    """A file's where there is a path, else the recording's own. Raises RefusedError where it has none that can be."""
    if path is not None:
        return Known(load_calibration(path), str(path))
    if isinstance(recording, BagRecording):
        return _bag_calibration(recording)
    if isinstance(recording, FolderRecording):
        return Known(load_calibration(recording.calibration_path), str(recording.calibration_path))
    raise RefusedError(f"{recording.path}: has no calibration of its own: --calibration gives one")


def _bag_calibration(recording: BagRecording) -> Known:
    found = read_geometry(recording)
    try:
        calibration = Calibration(
            image_size=found.camera.image_size,
            K=found.camera.K,
            distortion=found.camera.distortion,
            T_camera_laser=found.T_camera_laser,
            T_base_laser=found.T_base_laser,
            laser_height_m=float(found.T_base_laser[2, 3]),
        )
    except ValueError as error:
        raise RefusedError(f"{recording.path}: {found.source}: {error}: --calibration gives a file instead") from error
    return Known(calibration, found.source)
