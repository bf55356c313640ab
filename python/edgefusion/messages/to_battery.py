# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The battery from BatteryState."""

from __future__ import annotations

import math
from typing import NamedTuple, Optional

from edgefusion.messages.cdr import WireError
from edgefusion.messages.sensor_msgs import BatteryState
from edgefusion.messages.stamps import Stamper

_CHARGING = {
    BatteryState.POWER_SUPPLY_STATUS_CHARGING: True,
    BatteryState.POWER_SUPPLY_STATUS_DISCHARGING: False,
    BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING: False,
}


class Battery(NamedTuple):
    """charging: None where nobody says it."""

    stamp_ns: int
    voltage_v: float
    charging: Optional[bool]


def to_battery(message: BatteryState, stamper: Stamper) -> Battery:
    """Raises WireError for a voltage that is none."""
    if not 0 <= message.voltage < math.inf:
        raise WireError(f"battery: expected 0 V or more, got {message.voltage}")
    charging = _CHARGING.get(message.power_supply_status)
    return Battery(stamper.to_ns(message.header.stamp), message.voltage, charging)
