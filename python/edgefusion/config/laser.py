# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of a SICK LMS2xx: its line, what a scan covers, and whether its memory may be written."""

from __future__ import annotations

from typing import Literal

import msgspec

from edgefusion.config.strict import check_fields
from edgefusion.errors import RefusedError


class LaserConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the scanner is switched to at every start; it forgets that at power-off, but for its memory."""

    # 500000 only over RS-422, by a jumper in the plug.
    baudrate: Literal[38400, 500000] = 38400
    # 180 degrees at 1 or 0.5, or 100 degrees at 1, 0.5 or 0.25 degrees.
    beams: Literal[181, 361, 101, 201, 401] = 361
    # Every turn of the mirror by itself, 75 a second at 500000 baud, instead of whole scans.
    partial_scans: bool = False
    # 0 to 2 reach 8.18 m in millimetres, 3 and 4 16.37 m, 5 and 6 32.7 m.
    measuring_mode: Literal[0, 1, 2, 3, 4, 5, 6] = 0
    unit: Literal["mm", "cm"] = "mm"
    # Measuring mode and unit are in an EEPROM, which wears out: written only where they differ and this is true.
    write_eeprom: bool = False

    def __post_init__(self) -> None:
        check_fields(self)
        if self.partial_scans and self.baudrate < 500000:
            raise RefusedError(f"partial_scans: expected a baudrate of 500000 with them, got {self.baudrate}")
