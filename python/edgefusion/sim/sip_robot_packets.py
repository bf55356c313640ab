# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The packets of a simulated Pioneer."""

from __future__ import annotations

import struct
from typing import Iterable, Tuple

from edgefusion.drivers.sip_config import CONFIG_TYPE
from edgefusion.drivers.sip_frame import frame
from edgefusion.drivers.sip_status import E_STOP_PRESSED, MOTORS_ENABLED
from edgefusion.sim.sip_robot_character import Character

OUT_OF_STEP = frame(b"\xff")
NOTHING_COUNTS = 5000
_STANDING, _MOVING, _ENCODERS, _IO = 0x32, 0x33, 0x90, 0xF0
_SONAR_ARRAYS = 0x1E
_LOW_BATTERY_DV, _SHUTDOWN_DV = 115, 100


def identity(character: Character) -> bytes:
    """The last reply of the handshake."""
    return frame(b"\x02" + b"".join(_text(each) for each in (character.name, character.type, character.subtype)))


def parameters(character: Character) -> bytes:
    """The CONFIGpac; with a checksum that does not match from the robots that send it so."""
    c = character
    body = bytes([CONFIG_TYPE]) + b"".join(_text(each) for each in (c.type, c.subtype, c.serial)) + b"\0"
    body += struct.pack("<5H", c.top_turn_dps, c.top_speed_mmps, c.top_turn_dps2, c.top_speed_mmps2, 400)
    body += _text(c.name) + struct.pack("<BBB", c.sip_cycle_ms, 0, 0) + struct.pack("<HHB", 0, 1, 1)
    body += struct.pack("<HHHB", _LOW_BATTERY_DV, 0, c.watchdog_ms, 0) + struct.pack("<4H", 200, 8, 400, 100)
    body += struct.pack("<2H", c.top_turn_dps, c.top_speed_mmps)
    body += struct.pack("<5H", c.top_turn_dps2, c.top_turn_dps2, 40, 20, 0)
    body += struct.pack("<5H", c.top_speed_mmps2, c.top_speed_mmps2, 40, 30, 0)
    body += struct.pack("<6B", 5, 5, 0, 40, c.autobaud, 0) + struct.pack(
        "<hBBHH", 0, 0, 0, c.ticks_per_mm, _SHUTDOWN_DV
    )
    body += _text(c.firmware)
    packet = frame(body)
    return packet if c.config_packet == "right" else packet[:-2] + bytes(byte ^ 0x55 for byte in packet[-2:])


def status(
    counts: Tuple[int, int, int],
    wheels_mmps: Tuple[int, int],
    turn_ddps: int,
    battery_dv: int,
    stalled: Tuple[bool, bool],
    bumpers: Tuple[int, int],
    motors: bool,
    e_stop: bool,
    sonar_on: bool,
    sonars: Iterable[Tuple[int, int]],
    digital: Tuple[int, int],
) -> bytes:
    """A standard SIP. counts: x, y, heading. bumpers: at the front, at the back, bit 0 the first. sonars: number and
    millimetres of those that fired. digital: in, out."""
    fired = tuple(sonars)
    flags = MOTORS_ENABLED * motors | E_STOP_PRESSED * e_stop | _SONAR_ARRAYS * sonar_on
    kind = _MOVING if any(wheels_mmps) else _STANDING
    front, rear = bumpers
    body = struct.pack("<BHHhhhB", kind, counts[0], counts[1], counts[2], *wheels_mmps, min(255, battery_dv))
    body += struct.pack("<BBhHBB", rear << 1 | stalled[0], front << 1 | stalled[1], 0, flags, 0, len(fired))
    body += b"".join(struct.pack("<BH", *each) for each in fired)
    body += struct.pack("<5BHB", 0, 0, 0, digital[0], digital[1], battery_dv, 0) + struct.pack("<h", turn_ddps)
    return frame(body)


def encoders(left: int, right: int) -> bytes:
    """The ENCODERpac."""
    return frame(struct.pack("<Bii", _ENCODERS, left, right))


def io(digital: Tuple[int, int], bumpers: Tuple[int, int]) -> bytes:
    """The IOpac: digital inputs, the bumpers, no infrared; digital outputs; no analog inputs."""
    front, rear = bumpers
    return frame(bytes([_IO, 4, digital[0], front, rear, 0, 1, digital[1], 0]))


def _text(text: str) -> bytes:
    return text.encode("ascii") + b"\0"
