# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which processes have a device open, as far as the user may know."""

from __future__ import annotations

import os
from pathlib import Path
from typing import List

PROC = Path("/proc")


def holders_of(device: Path, proc: Path = PROC) -> List[str]:
    """Names and process ids; not this process. device: may be a link."""
    target, own = os.path.realpath(device), str(os.getpid())
    others = [each for each in proc.iterdir() if each.name.isdigit() and each.name != own]
    return [f"{_name(each)} (pid {each.name})" for each in others if _has_open(each, target)]


def _has_open(process: Path, target: str) -> bool:
    try:
        return any(os.readlink(each) == target for each in (process / "fd").iterdir())
    except OSError:  # it has ended, or belongs to somebody else
        return False


def _name(process: Path) -> str:
    try:
        return (process / "comm").read_text().strip()
    except OSError:
        return "a process"
