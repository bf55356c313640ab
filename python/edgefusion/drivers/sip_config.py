# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a Pioneer says of itself: its names in the handshake, and its parameters in the CONFIGpac."""

from __future__ import annotations

import struct
from dataclasses import dataclass, fields
from typing import Any

from edgefusion.errors import RefusedError

CONFIG_TYPE = 0x20
AUTOBAUD_RESETS = 2
"""Value of autobaud: the robot falls back to its usual speed at the end of a session."""

_TEXT = "text"
_WORD, _BYTE, _SIGNED = "<H", "B", "<h"
_MAX_TOP = 9999
_REQUIRED = 10  # fields, up to the name: the oldest firmware has them
_LAYOUT = (
    *((name, _TEXT) for name in ("type", "subtype", "serial")),
    ("four_motors", _BYTE),
    *((name, _WORD) for name in ("top_turn_dps", "top_speed_mmps", "top_turn_dps2", "top_speed_mmps2", "pwm_max")),
    ("name", _TEXT),
    *((name, _BYTE) for name in ("sip_cycle_ms", "host_baud", "aux_baud")),
    *((name, _WORD) for name in ("gripper", "front_sonar")),
    ("rear_sonar", _BYTE),
    *((name, _WORD) for name in ("low_battery_dv", "rev_count", "watchdog_ms")),
    ("p2_mpacs", _BYTE),
    *((name, _WORD) for name in ("stall_value", "stall_count", "joystick_mmps", "joystick_dps")),
    *((name, _WORD) for name in ("max_turn_dps", "max_speed_mmps")),
    *((name, _WORD) for name in ("turn_accel_dps2", "turn_decel_dps2", "turn_kp", "turn_kv", "turn_ki")),
    *((name, _WORD) for name in ("accel_mmps2", "decel_mmps2", "kp", "kv", "ki")),
    *((name, _BYTE) for name in ("front_bumpers", "rear_bumpers", "charger", "sonar_cycle", "autobaud", "has_gyro")),
    ("drift_factor", _SIGNED),
    *((name, _BYTE) for name in ("aux2_baud", "aux3_baud")),
    *((name, _WORD) for name in ("ticks_per_mm", "shutdown_dv")),
    ("firmware", _TEXT),
)


@dataclass(frozen=True)
class Identity:
    """The three names of the last reply of the handshake."""

    name: str
    type: str
    subtype: str


@dataclass(frozen=True)
class RobotConfig:
    """The parameters of a CONFIGpac that a driver needs; None: the firmware is too old to say."""

    type: str
    subtype: str
    serial: str
    name: str
    top_turn_dps: int
    top_speed_mmps: int
    top_turn_dps2: int
    top_speed_mmps2: int
    sip_cycle_ms: int | None = None
    front_sonar: int | None = None
    rear_sonar: int | None = None
    low_battery_dv: int | None = None
    rev_count: int | None = None
    watchdog_ms: int | None = None
    max_turn_dps: int | None = None
    max_speed_mmps: int | None = None
    turn_accel_dps2: int | None = None
    turn_decel_dps2: int | None = None
    accel_mmps2: int | None = None
    decel_mmps2: int | None = None
    front_bumpers: int | None = None
    rear_bumpers: int | None = None
    autobaud: int | None = None
    drift_factor: int | None = None
    ticks_per_mm: int | None = None
    shutdown_dv: int | None = None
    firmware: str | None = None


_WANTED = {each.name for each in fields(RobotConfig)}


def read_identity(body: bytes) -> Identity:
    """The names in a body of type 2. Raises RefusedError where it holds no three of them."""
    names, begin = [], 1
    for _ in range(3):
        name, begin = _read_text(body, begin)
        names.append(name)
    return Identity(*names)


def read_config(body: bytes) -> RobotConfig:
    """The CONFIGpac of a body. Raises RefusedError where it is none; its checksum says nothing on some robots."""
    if body[:1] != bytes([CONFIG_TYPE]):
        raise RefusedError(f"CONFIGpac: expected type {CONFIG_TYPE:#x}, got {body[:1].hex()}")
    values: dict[str, Any] = {}
    begin = 1
    for index, (name, layout) in enumerate(_LAYOUT):
        try:
            value, begin = _read_field(body, begin, layout)
        except RefusedError:
            if index < _REQUIRED:
                raise
            break
        if name in _WANTED:
            values[name] = value
    _require_plausible(values)
    return RobotConfig(**values)


def _require_plausible(values: dict[str, Any]) -> None:
    """Noise may begin with three zero bytes, which are three names; 9999 is a simulator's "any"."""
    if not (values["type"] and values["subtype"]):
        raise RefusedError("CONFIGpac: expected a type and a subtype, got none")
    for name in ("top_turn_dps", "top_speed_mmps"):
        if not 0 < values[name] <= _MAX_TOP:
            raise RefusedError(f"CONFIGpac: {name}: expected 1 to {_MAX_TOP}, got {values[name]}")


def _read_field(body: bytes, begin: int, layout: str) -> tuple[int | str, int]:
    if layout == _TEXT:
        return _read_text(body, begin)
    end = begin + struct.calcsize(layout)
    if end > len(body):
        raise RefusedError(f"CONFIGpac: expected more than {len(body)} bytes")
    (value,) = struct.unpack_from(layout, body, begin)
    return int(value), end


def _read_text(body: bytes, begin: int) -> tuple[str, int]:
    """The string that ends with a zero byte, and where the next field begins."""
    end = body.find(b"\x00", begin)
    text = body[begin : max(end, begin)]
    if end < 0 or any(not 0x20 <= byte <= 0x7E for byte in text):
        raise RefusedError(f"text: expected printable characters and a zero byte, got {body[begin:][:20].hex()}")
    return text.decode("ascii"), end + 1
