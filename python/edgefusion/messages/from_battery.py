# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The battery as BatteryState."""

from __future__ import annotations

import math
from typing import Optional

from edgefusion.messages.frames import BASE_LINK
from edgefusion.messages.sensor_msgs import BatteryState
from edgefusion.messages.stamps import Stamper


def from_battery(stamp_ns: int, voltage_v: float, stamper: Stamper, charging: Optional[bool] = None) -> BatteryState:
    """charging: None where the robot does not say it. What else ROS has room for nobody measures: NaN."""
    status = {
        None: BatteryState.POWER_SUPPLY_STATUS_UNKNOWN,
        True: BatteryState.POWER_SUPPLY_STATUS_CHARGING,
        False: BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
    }[charging]
    return BatteryState(
        stamper.header(stamp_ns, BASE_LINK),
        voltage_v,
        temperature=math.nan,
        current=math.nan,
        charge=math.nan,
        capacity=math.nan,
        design_capacity=math.nan,
        percentage=math.nan,
        power_supply_status=status,
        present=True,
    )
