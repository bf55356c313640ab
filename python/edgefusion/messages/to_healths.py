# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How the components are, from DiagnosticArray."""

from __future__ import annotations

from typing import Dict, NamedTuple

from edgefusion.messages.cdr import WireError
from edgefusion.messages.diagnostic_msgs import DiagnosticArray, DiagnosticStatus
from edgefusion.messages.from_healths import HARDWARE, STATE
from edgefusion.types import Health, HealthState


class Report(NamedTuple):
    """figures: what else a component says of itself, by name."""

    health: Health
    figures: Dict[str, str]


def to_healths(message: DiagnosticArray) -> list[Report]:
    """Raises WireError for a state that is none. What is not of edgefusion is left out."""
    return [_report(status) for status in message.status if status.hardware_id == HARDWARE]


def _report(status: DiagnosticStatus) -> Report:
    figures = {each.key: each.value for each in status.values}
    try:
        return Report(Health(status.name, HealthState(figures.pop(STATE, "")), status.message), figures)
    except ValueError as error:
        raise WireError(f"diagnostics: {status.name}: {error}") from None
