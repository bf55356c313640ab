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

    processes: Processes = ("bus", "base", "vision")
    """What this machine runs; the rest may run on another one. Vision is left out where [vision] has no model."""
    bus_silence_s: Seconds = 3.0
    """So long the bus may be silent before it is taken for dead."""
    base_silence_s: Seconds = 1.5
    """So long base may be silent: shorter than the 2 s after which a Pioneer stops by itself."""
    vision_silence_s: Seconds = 4.0
    """So long vision may be silent."""
    bus_start_s: Patience = 30.0
    """So long the bus may take from its start to its first sign of life: who kills a computer's slow starts when it is
    busy makes it busier."""
    base_start_s: Patience = 30.0
    """So long base may take from its start to its first sign of life; nothing moves meanwhile."""
    vision_start_s: Patience = 120.0
    """So long vision may take from its start to its first sign of life; it loads its model in that time."""
    first_pause_s: Seconds = 0.1
    """The pause before a process is started again, after its first failure; it doubles with each further one."""
    longest_pause_s: Seconds = 5.0
    """The pause doubles up to this."""
    vision_failures: Annotated[int, msgspec.Meta(ge=1, le=100)] = 5
    """Vision is given up when it failed so often within vision_failures_within_s. [failures]"""
    vision_failures_within_s: Patience = 60.0
    """Failures that are further apart are not counted together."""
    drive_without_vision: bool = True
    """Where vision was given up, the robot drives on without it; else all ends."""
    log_level: Literal["debug", "info", "warning", "error"] = "info"
    """What is told: this and what is worse."""

    def __post_init__(self) -> None:
        check_fields(self)
        if len(set(self.processes)) < len(self.processes):
            raise RefusedError(f"processes: expected each once, got {', '.join(self.processes)}")
        if self.longest_pause_s < self.first_pause_s:
            raise RefusedError(
                f"longest_pause_s: expected at least first_pause_s, {self.first_pause_s:g}, "
                f"got {self.longest_pause_s:g}"
            )
