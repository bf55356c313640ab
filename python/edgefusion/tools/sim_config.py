# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The configuration and the calibration of a simulated robot, for `edgefusion run` on its devices."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Dict, Mapping

from edgefusion.errors import RefusedError
from edgefusion.sim.live_devices import LiveDevices
from edgefusion.sim.rig import Rig
from edgefusion.tools.arguments import LAB_MODEL

MADE = "# Made by `edgefusion sim`, which takes it away when it ends.\n"
ROBOT, CALIBRATION = "robot.toml", "calibration.toml"

_DEVICES = """
[robot]
port = "{folder}/robot"

[laser]
port = "{folder}/laser"
baudrate = 500000

[base]
laser_pose = {laser_pose}
"""
_SEES = """
[camera]
source = "{camera}"

[vision]
model = "{model}"
calibration = "calibration.toml"
"""
_CALIBRATION = """version = 1
image_size = {size}
K = {K}
distortion = {distortion}
T_camera_laser = {T_camera_laser}
T_base_laser = {T_base_laser}
laser_height_m = {height_m}
"""


def check_free(folder: Path) -> None:
    """Raises RefusedError where somebody else's files are in the way."""
    for path in (folder / ROBOT, folder / CALIBRATION):
        if path.exists() and not path.read_text(encoding="utf-8", errors="replace").startswith(MADE):
            raise RefusedError(f"--links: expected a folder without a {path.name} of yours, got {path}")


def write_config(folder: Path, devices: LiveDevices) -> Dict[Path, str]:
    """Into the folder with the links to their ports; vision only with a camera. Returns what it wrote, the
    configuration first. Raises RefusedError as check_free."""
    folder, rig = folder.resolve(), devices.world.rig
    check_free(folder)
    pose = [*rig.T_base_laser[:2, 3].tolist(), 0.0]
    text = MADE + _DEVICES.format(folder=folder, laser_pose=pose)
    written = {folder / ROBOT: text}
    if devices.pictures is not None:
        written[folder / ROBOT] += _SEES.format(camera=devices.pictures.url + "stream", model=LAB_MODEL)
        written[folder / CALIBRATION] = MADE + calibration_text(rig)
    for path, content in written.items():
        path.write_text(content, encoding="utf-8")
    return written


def remove_config(written: Mapping[Path, str]) -> None:
    """The ports are gone. What was changed since is somebody's."""
    for path, content in written.items():
        with suppress(OSError, UnicodeDecodeError):
            if path.read_text(encoding="utf-8") == content:
                path.unlink()


def calibration_text(rig: Rig) -> str:
    """What a perfect calibration of a simulated rig says."""
    return _CALIBRATION.format(
        size=list(rig.image_size),
        K=rig.K.tolist(),
        distortion=list(rig.distortion),
        T_camera_laser=rig.T_camera_laser.tolist(),
        T_base_laser=rig.T_base_laser.tolist(),
        height_m=rig.laser_height_m,
    )
