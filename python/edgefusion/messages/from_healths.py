# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How the components are, as DiagnosticArray."""

from __future__ import annotations

from typing import Mapping, Optional, Sequence

from edgefusion.messages.diagnostic_msgs import DiagnosticArray, DiagnosticStatus, KeyValue
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Health, HealthState

HARDWARE = "edgefusion"
STATE = "state"
"""The key that holds the state in our words: ROS has other levels."""
LEVELS = {
    HealthState.OK: DiagnosticStatus.OK,
    HealthState.STARTING: DiagnosticStatus.WARN,
    HealthState.DEGRADED: DiagnosticStatus.WARN,
    HealthState.FAILED: DiagnosticStatus.ERROR,
}

Figures = Mapping[str, Mapping[str, str]]


def from_healths(
    stamp_ns: int, healths: Sequence[Health], stamper: Stamper, figures: Optional[Figures] = None
) -> DiagnosticArray:
    """figures: by component, what else there is to say of it, as stage times: name with unit, and value."""
    status = [_status(health, (figures or {}).get(health.component, {})) for health in healths]
    return DiagnosticArray(stamper.header(stamp_ns, ""), status)


def _status(health: Health, figures: Mapping[str, str]) -> DiagnosticStatus:
    values = [KeyValue(STATE, health.state.value), *(KeyValue(*each) for each in figures.items())]
    return DiagnosticStatus(LEVELS[health.state], health.component, health.reason, HARDWARE, values)
