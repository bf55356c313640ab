# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is asked of the robot in queries, and what it answers: strict JSON."""

from __future__ import annotations

import sys
from typing import Literal, Optional, Tuple, Type, TypeVar

import msgspec

from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Metres = Annotated[float, msgspec.Meta(ge=-1e4, le=1e4)]
Angle = Annotated[float, msgspec.Meta(ge=-7, le=7)]
_ONE_LINE = r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*\Z"
"""It goes into logs, onto terminals, and into texts that end with a zero."""

Text = Annotated[str, msgspec.Meta(max_length=200, pattern=_ONE_LINE)]
Label = Annotated[str, msgspec.Meta(min_length=1, max_length=200, pattern=_ONE_LINE)]
Labels = Annotated[Tuple[Label, ...], msgspec.Meta(max_length=32)]


class GoalRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """theta [rad]; none: any heading. frame: what the coordinates are in, base_link as it is when the robot is asked.
    Tolerances [m], [rad]; none: the robot's."""

    x_m: Metres
    y_m: Metres
    theta: Optional[Angle] = None
    frame: Literal["odom", "base_link"] = "odom"
    id: Annotated[str, msgspec.Meta(max_length=64, pattern=_ONE_LINE)] = ""
    position_tolerance_m: Optional[Annotated[float, msgspec.Meta(gt=0, le=100)]] = None
    heading_tolerance: Optional[Annotated[float, msgspec.Meta(gt=0, le=7)]] = None


class GotoRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Drive to these, in this order. inspect: what to inspect on the way; none: as before."""

    goals: Annotated[Tuple[GoalRequest, ...], msgspec.Meta(min_length=1, max_length=100)]
    inspect: Optional[Labels] = None
    version: Literal[1] = 1


class StopRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Stand still until resumed. cancel: also give up the goals that are left."""

    reason: Text = "asked by an operator"
    cancel: bool = False
    version: Literal[1] = 1


class ResumeRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Leave the stop, or take the robot back from cmd_vel."""

    version: Literal[1] = 1


class InspectRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Inspect things with these labels from now on; none: nothing."""

    labels: Labels
    version: Literal[1] = 1


class Answer(msgspec.Struct, frozen=True, omit_defaults=True):
    """reason: why it was refused. stamp_ns: when it was answered, by the robot's monotonic clock."""

    accepted: bool
    reason: str = ""
    stamp_ns: int = 0


R = TypeVar("R", bound=msgspec.Struct)


def read_json(kind: Type[R], payload: bytes) -> R:
    """Raises RefusedError for what is no such request."""
    try:
        return msgspec.json.decode(payload, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError, OverflowError) as error:
        raise RefusedError(f"{kind.__name__}: {error}") from error
