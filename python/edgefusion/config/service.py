# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the supervisor: which processes it starts, and when it takes one for dead."""

from __future__ import annotations

import sys
from typing import Literal, Tuple

import msgspec

from edgefusion.config.strict import Seconds, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Process = Literal["bus", "base", "vision"]
Processes = Annotated[Tuple[Process, ...], msgspec.Meta(min_length=1, max_length=3)]
Patience = Annotated[float, msgspec.Meta(gt=0, le=3600)]


class ServiceConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What `edgefusion run` starts and watches. A process that is silent for too long is killed and started again."""

    # What this machine runs; the rest may run on another one.
    processes: Processes = ("bus", "base", "vision")
    # So long each process may be silent. That of base is shorter than the 2 s after which a Pioneer stops by itself.
    bus_silence_s: Seconds = 3.0
    base_silence_s: Seconds = 1.5
    vision_silence_s: Seconds = 4.0
    # So long each may take from its start to its first sign of life; vision loads its model in that time.
    bus_start_s: Patience = 10.0
    base_start_s: Patience = 10.0
    vision_start_s: Patience = 120.0
    # The pause before a process is started again: after its first failure, doubled with each further one, at most.
    first_pause_s: Seconds = 0.1
    longest_pause_s: Seconds = 5.0
    # Vision is given up when it failed so often within so long. Then the robot drives on without it, or all ends.
    vision_failures: Annotated[int, msgspec.Meta(ge=1, le=100)] = 5
    vision_failures_within_s: Patience = 60.0
    drive_without_vision: bool = True
    # What is told: this and what is worse.
    log_level: Literal["debug", "info", "warning", "error"] = "info"

    def __post_init__(self) -> None:
        check_fields(self)
        if len(set(self.processes)) < len(self.processes):
            raise RefusedError(f"processes: expected each once, got {', '.join(self.processes)}")
        if self.longest_pause_s < self.first_pause_s:
            raise RefusedError(
                f"longest_pause_s: expected at least first_pause_s, {self.first_pause_s:g}, "
                f"got {self.longest_pause_s:g}"
            )
