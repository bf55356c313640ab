# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The standard SIP, in which a Pioneer reports its state ten times a second: of any length and number of sonars.

Counts and speeds are the robot's own; what they are in metres depends on its board.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import NamedTuple

from edgefusion.errors import RefusedError

STATUS_TYPES = frozenset(range(0x30, 0x40))

MOTORS_ENABLED, E_STOP_PRESSED = 0x0001, 0x0020
"""Bits of the flags."""

_FIXED = struct.Struct("<BHHhhhBBBhHBB")
_SONAR = struct.Struct("<BH")
_MAX_SPEED, _MAX_HEADING, _SONARS = 3000, 4096, 64
_TAIL = (
    ("gripper", "B"),
    ("analog_port", "B"),
    ("analog", "B"),
    ("digital_in", "B"),
    ("digital_out", "B"),
    ("precise_battery_dv", "<H"),
    ("charge_state", "B"),
    ("turn_ddps", "<h"),
    ("faults", "<H"),
    ("lateral_speed", "<h"),
    ("temperature_c", "b"),
    ("charge_percent", "B"),
)


class Sonar(NamedTuple):
    """The newest echo of one sonar, numbered from 0, in the robot's unit of range."""

    number: int
    range_counts: int


@dataclass(frozen=True)
class Status:
    """One standard SIP. x_counts, y_counts: 15 bits that wrap. heading_counts: 4096 a turn, left positive.

    bumpers_rear, bumpers_front: bit 0 is the first bumper. battery_dv: decivolts. What a shorter SIP leaves out is
    None.
    """

    x_counts: int
    y_counts: int
    heading_counts: int
    left_speed: int
    right_speed: int
    battery_dv: int
    stall_left: bool
    stall_right: bool
    bumpers_rear: int
    bumpers_front: int
    flags: int
    compass: int
    sonars: tuple[Sonar, ...]
    gripper: int | None = None
    analog_port: int | None = None
    analog: int | None = None
    digital_in: int | None = None
    digital_out: int | None = None
    charge_state: int | None = None
    turn_ddps: int | None = None
    faults: int | None = None
    lateral_speed: int | None = None
    temperature_c: int | None = None
    charge_percent: int | None = None

    @property
    def motors_enabled(self) -> bool:
        return bool(self.flags & MOTORS_ENABLED)

    @property
    def e_stop_pressed(self) -> bool:
        return bool(self.flags & E_STOP_PRESSED)


def read_status(body: bytes) -> Status:
    """The SIP of a body. Raises RefusedError where it is none, is cut short or says what no Pioneer can."""
    if not body or body[0] not in STATUS_TYPES or len(body) < _FIXED.size:
        raise RefusedError(f"status: expected at least {_FIXED.size} bytes of type 0x30 to 0x3f, got {body[:1].hex()}")
    _, x, y, heading, left, right, battery, rear, front, _, flags, compass, count = _FIXED.unpack_from(body)
    tail_begin = _FIXED.size + count * _SONAR.size
    if len(body) < tail_begin:
        raise RefusedError(f"status: expected {count} sonars, got {len(body) - _FIXED.size} bytes of them")
    sonars = tuple(Sonar(*each) for each in _SONAR.iter_unpack(body[_FIXED.size : tail_begin]))
    _require_plausible(heading, left, right, sonars)
    tail = _read_tail(body, tail_begin)
    return Status(
        x_counts=x & 0x7FFF,
        y_counts=y & 0x7FFF,
        heading_counts=heading,
        left_speed=left,
        right_speed=right,
        battery_dv=tail.pop("precise_battery_dv", 0) or battery,  # who has no voltage reports nothing
        stall_left=bool(rear & 1),
        stall_right=bool(front & 1),
        bumpers_rear=rear >> 1,
        bumpers_front=front >> 1,
        flags=flags,
        compass=compass,
        sonars=sonars,
        **tail,
    )


def _read_tail(body: bytes, begin: int) -> dict[str, int]:
    """The fields after the sonars, as far as the SIP goes."""
    fields = {}
    for name, layout in _TAIL:
        end = begin + struct.calcsize(layout)
        if end > len(body):
            break
        (fields[name],) = struct.unpack_from(layout, body, begin)
        begin = end
    return fields


def _require_plausible(heading: int, left: int, right: int, sonars: tuple[Sonar, ...]) -> None:
    """A Pioneer drives 2.2 m/s at most; a SIP names a sonar once."""
    if abs(heading) > _MAX_HEADING:
        raise RefusedError(f"status: expected a heading within {_MAX_HEADING} counts, got {heading}")
    if max(abs(left), abs(right)) > _MAX_SPEED:
        raise RefusedError(f"status: expected wheels within {_MAX_SPEED} mm/s, got {left} and {right}")
    numbers = {sonar.number for sonar in sonars}
    if len(numbers) < len(sonars) or any(number >= _SONARS for number in numbers):
        raise RefusedError(f"status: expected different sonars below {_SONARS}, got {[s.number for s in sonars]}")
