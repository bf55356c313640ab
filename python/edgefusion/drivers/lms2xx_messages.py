# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What an LMS2xx is asked and what it answers, but for its scans: payloads without their frames."""

from __future__ import annotations

from dataclasses import dataclass

from edgefusion.drivers.lms2xx_scan import VARIANTS, Variant
from edgefusion.errors import RefusedError

STATUS, TYPE, GET_CONFIGURATION = b"\x31", b"\x3a", b"\x74"
STREAM_ALL, STREAM_PARTIAL, STOP = b"\x20\x24", b"\x20\x2a", b"\x20\x25"
INSTALLATION_MODE = b"\x20\x00SICK_LMS"
SPEEDS = {9600: b"\x20\x42", 19200: b"\x20\x41", 38400: b"\x20\x40", 500000: b"\x20\x48"}

POWER_ON, NOT_NOW = 0x90, 0x92
CENTIMETRES, MILLIMETRES = 0, 1

_MODE_AT, _UNIT_AT = 5, 6
_ANGLE_AT, _STATUS_MODE_AT, _STATUS_UNIT_AT = 107, 102, 122


def reply_code(command: bytes) -> int:
    """What the reply to a command begins with."""
    return command[0] | 0x80


def set_variant(variant: Variant) -> bytes:
    """The command for an angle and resolution of full scans."""
    return b"\x3b" + variant.angle.to_bytes(2, "little") + variant.resolution.to_bytes(2, "little")


@dataclass(frozen=True)
class LaserStatus:
    """What of the answer to STATUS matters here. status: the byte at its end."""

    measuring_mode: int
    variant: Variant
    unit: int
    status: int


def parse_status(payload: bytes) -> LaserStatus:
    """Raises RefusedError for an answer too short to be one, or with a variant that there is not."""
    if len(payload) <= _STATUS_UNIT_AT + 1:
        raise RefusedError(f"status: expected more than {_STATUS_UNIT_AT + 1} bytes, got {len(payload)}")
    angle, resolution = (int.from_bytes(payload[at : at + 2], "little") for at in (_ANGLE_AT, _ANGLE_AT + 2))
    variant = Variant(angle, resolution)
    if variant not in VARIANTS:
        raise RefusedError(f"status: expected one of {sorted(map(tuple, VARIANTS))}, got {tuple(variant)}")
    return LaserStatus(payload[_STATUS_MODE_AT], variant, payload[_STATUS_UNIT_AT], payload[-1])


def parse_type(payload: bytes) -> str:
    """Of the answer to TYPE: as "LMS200;30106;V02.10"."""
    return payload[1:-1].decode("latin-1").strip("\0 ")


@dataclass(frozen=True)
class Configuration:
    """The block in the EEPROM. Its length differs by firmware: it goes back as it came, but for what shall change."""

    block: bytes

    def __post_init__(self) -> None:
        if len(self.block) <= _UNIT_AT:
            raise RefusedError(f"configuration: expected more than {_UNIT_AT} bytes, got {len(self.block)}")

    @property
    def measuring_mode(self) -> int:
        return self.block[_MODE_AT]

    @property
    def unit(self) -> int:
        return self.block[_UNIT_AT]

    def changed(self, measuring_mode: int, unit: int) -> Configuration:
        return Configuration(self.block[:_MODE_AT] + bytes([measuring_mode, unit]) + self.block[_UNIT_AT + 1 :])

    def command(self) -> bytes:
        """Writes it into the EEPROM; the scanner must be in INSTALLATION_MODE."""
        return b"\x77" + self.block


def parse_configuration(payload: bytes) -> Configuration:
    """Of the answer to GET_CONFIGURATION. Raises RefusedError for one that is too short."""
    return Configuration(payload[1:-1])


def check_mode_reply(payload: bytes) -> None:
    """Raises RefusedError where a mode or speed was not taken."""
    result = payload[1] if len(payload) > 2 else -1
    if result != 0:
        why = {1: "wrong password", 2: "fault in the scanner"}.get(result, payload.hex())
        raise RefusedError(f"mode: expected the scanner to take it, got: {why}")


def check_set_reply(payload: bytes, what: str) -> None:
    """Raises RefusedError where a variant or configuration was not taken."""
    if len(payload) < 3 or payload[1] != 1:
        raise RefusedError(f"{what}: expected the scanner to take it, got {payload.hex()}")
