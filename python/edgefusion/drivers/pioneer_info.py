# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a Pioneer says that it is, and what follows from it."""

from __future__ import annotations

from dataclasses import dataclass

from edgefusion.drivers.pioneer_factors import Factors
from edgefusion.drivers.pioneer_limits import Limits
from edgefusion.drivers.sip_config import Identity, RobotConfig

_SILENCE_S, _CYCLES = 0.25, 2.5
_USUAL_CYCLE_MS, _NS_PER_MS = 100, 1_000_000


@dataclass(frozen=True)
class RobotInfo:
    """One session. parameters: None where the robot sent no CONFIGpac. baudrate: None over a network."""

    identity: Identity
    parameters: RobotConfig | None
    factors: Factors
    limits: Limits
    baudrate: int | None

    @property
    def cycle_ns(self) -> int:
        """From report to report."""
        cycle_ms = self.parameters.sip_cycle_ms if self.parameters else None
        return (cycle_ms or _USUAL_CYCLE_MS) * _NS_PER_MS

    @property
    def silence_s(self) -> float:
        """A pause of more than this between its bytes is a loss."""
        return max(_SILENCE_S, _CYCLES * self.cycle_ns / 1e9)

    @property
    def firmware(self) -> str:
        """Its version; empty where the robot does not say."""
        return (self.parameters.firmware if self.parameters else None) or ""
