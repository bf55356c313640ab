# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the tests of `edgefusion doctor` examine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from edgefusion.clock import SimClock
from edgefusion.config import Config
from edgefusion.sim.wire_device import WireDevice
from edgefusion.tools.doctor_finding import Examination, Finding
from virtual_port import VirtualLine

SEES = {"vision": {"model": "net", "calibration": "rig.toml"}}
"""Changes by which there is vision; neither file is there."""


def examination(folder: Path, **changes: dict[str, Any]) -> Examination:
    """Of the defaults with changes, section by section; its configuration is a file in the folder."""
    config = Config()
    for name, values in changes.items():
        section = msgspec.structs.replace(getattr(config, name), **values)
        config = msgspec.structs.replace(config, **{name: section})
    path = folder / "robot.toml"
    path.touch()
    return Examination(config, path, lock_folder=folder)


def on_a_line(monkeypatch: Any, device: WireDevice) -> VirtualLine:
    """From now on every port leads to the device, in a time of its own."""
    line = VirtualLine(device, SimClock(5 * 10**9))
    line.serve(monkeypatch)
    return line


def told(findings: list[Finding]) -> list[str]:
    """How each is, and of what."""
    return [f"{each.state.value} {each.check}" for each in findings]
