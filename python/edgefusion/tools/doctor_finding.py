# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What `edgefusion doctor` finds, and what of it the exit code says."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Iterable, Set, Tuple

from edgefusion.config import Config

CHECKS = (
    "ports",
    "robot",
    "laser",
    "camera",
    "model",
    "calibration",
    "bus",
    "clock",
    "disk",
    "permissions",
)
"""In the order in which they are made, and mended."""

HOLDER = "edgefusion doctor"
"""What others are told who want a port that is looked at."""

END_IT = "end that process; where it is a service, `sudo systemctl stop` it"
"""What to do about who holds a port."""

FIRST_CODE = 10
"""Of the first check; the others follow."""


class State(Enum):
    """How it is."""

    OK = "ok"
    WARNING = "warning"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class Finding:
    """check: one of CHECKS. text: what is there, or what is wrong. cure: what to do about it."""

    check: str
    state: State
    text: str
    cure: str = ""


@dataclass
class Examination:
    """path: of the configuration. lock_folder: of the ports' locks, by default the usual one.

    What one check has found out for those after it: unusable: ports that cannot be opened. picture_size: width and
    height of what the camera gives.
    """

    config: Config
    path: Path
    lock_folder: Path | None = None
    unusable: Set[str] = field(default_factory=set)
    picture_size: Tuple[int, int] | None = None

    def runs(self, process: str) -> bool:
        """Whether this machine runs it."""
        return process in self.config.processes

    def why_no_vision(self) -> str:
        """Where this machine does not run it."""
        to_run = "vision" in self.config.service.processes
        return "[vision] has no model: the robot only drives" if to_run else "vision runs on another machine"


def exit_code(findings: Iterable[Finding]) -> int:
    """0, or that of the first check that failed."""
    failed = [CHECKS.index(each.check) for each in findings if each.state is State.FAILED]
    return FIRST_CODE + min(failed) if failed else 0
