# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of a SICK LMS2xx: its line, what a scan covers, and whether its memory may be written."""

from __future__ import annotations

from typing import Literal

import msgspec

from edgefusion.config.strict import Place, check_fields
from edgefusion.errors import RefusedError

_FRAME_BYTES = 10
"""Of a scan's telegram, beside two for each beam."""


class LaserConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A SICK LMS2xx: what it is switched to at every start; it forgets that at power-off, but for its memory."""

    port: Place = "/dev/laser"
    """A serial port, or socket://HOST:PORT. docs/wiring.md says how it gets a name that stays."""
    baudrate: Literal[38400, 500000] = 38400
    """500000 only over RS-422, by a jumper in the plug. [baud]"""
    beams: Literal[181, 361, 101, 201, 401] = 361
    """Of a scan: 180 degrees at 1 or 0.5, or 100 degrees at 1, 0.5 or 0.25 degrees. [beams]"""
    partial_scans: bool = False
    """Every turn of the mirror by itself, 75 a second at 500000 baud, instead of whole scans."""
    measuring_mode: Literal[0, 1, 2, 3, 4, 5, 6] = 0
    """0 to 2 reach 8.18 m in millimetres, 3 and 4 16.37 m, 5 and 6 32.7 m. [number]"""
    unit: Literal["mm", "cm"] = "mm"
    """Of the ranges as the scanner sends them."""
    write_eeprom: bool = False
    """Measuring mode and unit are in an EEPROM, which wears out: written only where they differ and this is true."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.partial_scans and self.baudrate < 500000:
            raise RefusedError(f"partial_scans: expected a baudrate of 500000 with them, got {self.baudrate}")

    @property
    def telegram_s(self) -> float:
        """How long a whole scan is on the line, ten bits a byte; so old is the newest when it is there."""
        return 10 * (2 * self.beams + _FRAME_BYTES) / self.baudrate
