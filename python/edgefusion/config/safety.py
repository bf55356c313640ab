# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the safety gate: how old what may be, and whose failure stops the robot for how long."""

from __future__ import annotations

import sys
from typing import Tuple

import msgspec

from edgefusion.config.strict import Seconds, UpTo10, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Component = Annotated[str, msgspec.Meta(min_length=1, max_length=64)]
Components = Annotated[Tuple[Component, ...], msgspec.Meta(max_length=32)]


class SafetyConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the safety gate lets through. Ages count from capture; a command's from when it was computed."""

    max_scan_age_s: Seconds = 0.75
    """A robot without a newer scan stops. A 38400-baud laser needs 0.75 s, one at 500 kbaud 0.2 s."""
    max_odometry_age_s: Seconds = 0.25
    """A robot without newer odometry stops: 2.5 of a Pioneer's 100 ms cycles."""
    max_detections_age_s: Seconds = 1.5
    """Older detections are only noted: obstacles are avoided by the laser."""
    max_command_age_s: Seconds = 0.3
    """Older commands are not driven."""
    good_scans: Annotated[int, msgspec.Meta(ge=1, le=100)] = 5
    """So many fresh scans in a row let the robot go again. [scans]"""
    cycle_s: Seconds = 0.05
    """The period of the gate's steps."""
    max_cycle_s: Seconds = 0.2
    """The longest period that is no reason to stop."""
    stopping_room_m: UpTo10 = 0.75
    """From where its newest scan was taken, the robot can always stop within this: the older the scan, the slower."""
    required: Components = ("robot", "laser")
    """Components that must report before anything moves. Any component's failure stops the robot for as long as it
    lasts, where it is not named below."""
    latching: Components = ("robot",)
    """Components whose failure stops the robot until an operator resumes."""
    optional: Components = ("camera", "vision", "bus")
    """Components whose failure is only noted. The bus is among them: a robot that is on its way drives on by itself,
    and without it no goal or cmd_vel comes. No stop comes either: where somebody must be able to stop it at any time,
    set require_operator in [bus], by which it stands as soon as nobody is heard."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.max_cycle_s <= self.cycle_s:
            raise RefusedError(f"max_cycle_s: expected more than cycle_s, {self.cycle_s:g}, got {self.max_cycle_s:g}")
        both = sorted(set(self.optional) & {*self.required, *self.latching})
        if both:
            raise RefusedError(f"optional: expected none that is required or latching, got {', '.join(both)}")
