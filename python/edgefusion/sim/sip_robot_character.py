# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a simulated Pioneer differs from another: its board, its names, and the habits of its firmware."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from edgefusion.errors import RefusedError


@dataclass(frozen=True)
class Character:
    """distance_mm: of a count of its odometry. counter_bits: where that wraps. watchdog_ms: so long without a command
    it goes on. autobaud: 2: back at its usual speed after a session. tops: [mm/s], [deg/s], [mm/s^2], [deg/s^2].
    ticks_per_mm: of its wheels' encoders. says_out_of_step: answers a step out of turn with FF, else with nothing."""

    subtype: str
    distance_mm: float
    counter_bits: int = 15
    config_packet: Literal["right", "wrong", "missing"] = "right"
    name: str = "Simulated_1"
    type: str = "Pioneer"
    serial: str = "SIM"
    firmware: str = "S.0"
    baudrate: int = 9600
    autobaud: int = 2
    watchdog_ms: int = 2000
    sip_cycle_ms: int = 100
    sonars: int = 16
    top_speed_mmps: int = 1000
    top_turn_dps: int = 360
    top_speed_mmps2: int = 2000
    top_turn_dps2: int = 300
    ticks_per_mm: int = 128
    says_out_of_step: bool = True

    def __post_init__(self) -> None:
        if self.counter_bits not in (15, 16):
            raise RefusedError(f"counter_bits: expected 15 or 16, got {self.counter_bits}")
        if self.config_packet not in ("right", "wrong", "missing"):
            raise RefusedError(f"config_packet: expected right, wrong or missing, got {self.config_packet!r}")
        if not self.distance_mm > 0:
            raise RefusedError(f"distance_mm: expected more than 0, got {self.distance_mm}")


H8 = Character("p3dx", 0.485)
"""The old board: P2OS, AROS."""

SH = Character("p3dx-sh", 1.0)
"""The newer one: ARCOS."""

CHARACTERS = {each.subtype: each for each in (H8, SH)}
