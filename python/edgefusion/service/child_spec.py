# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a supervisor is told of a process that it is to run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from edgefusion.errors import RefusedError


@dataclass(frozen=True)
class GiveUp:
    """After so many failures within so long it is not started again."""

    failures: int
    within_s: float


@dataclass(frozen=True)
class ChildSpec:
    """start_s: from its start to its first beat; silence_s: between two beats; for longer, and it is killed.

    give_up: None: it is started again for ever. required: all ends where it is given up. drives: a robot, which is to
    be stopped whenever it dies. nice: so much nicer than the supervisor, for what may wait. oom_score_adj: 0 to 1000,
    for what is to be killed first when memory runs out.
    """

    name: str
    argv: Tuple[str, ...]
    start_s: float
    silence_s: float
    give_up: GiveUp | None = None
    required: bool = True
    drives: bool = False
    first_pause_s: float = 0.1
    longest_pause_s: float = 5.0
    nice: int = 0
    oom_score_adj: int = 0

    def __post_init__(self) -> None:
        if not self.name or not self.argv:
            raise RefusedError(f"child {self.name!r}: expected a name and a command, got {self.argv!r}")
        for what in ("start_s", "silence_s", "first_pause_s", "longest_pause_s"):
            if not getattr(self, what) > 0:
                raise RefusedError(f"child {self.name!r}: {what}: expected more than 0, got {getattr(self, what):g}")
