# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The status byte at the end of everything that an LMS2xx says, as health."""

from __future__ import annotations

from edgefusion.types import Health, HealthState

COMPONENT = "laser"

_SEVERITIES = {1: "info", 2: "warning", 3: "error", 4: "fatal"}
_ERROR = 3
_DAZZLED, _POLLUTED = 0x40, 0x80


def health_of(status: int) -> Health:
    """Pollution, dazzle and warnings degrade: the ranges are still good for something. Errors fail."""
    severity = status & 0x07
    reasons = [f"reports: {_SEVERITIES.get(severity, f'severity {severity}')}"] if severity > 1 else []
    reasons += ["front window polluted"] if status & _POLLUTED else []
    reasons += ["implausible values: dazzled"] if status & _DAZZLED else []
    if not reasons:
        return Health(COMPONENT, HealthState.OK)
    state = HealthState.FAILED if severity >= _ERROR else HealthState.DEGRADED
    return Health(COMPONENT, state, ", ".join(reasons))
