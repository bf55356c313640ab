# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What may stand in a world: one module per family of objects, all of them in CATALOGUE by name."""

from __future__ import annotations

from edgefusion.sim.kinds import (
    appliances,
    car,
    cash,
    desk,
    joystick,
    lab,
    nameless,
    office,
    slot,
    store,
    street,
    vending,
)
from edgefusion.sim.kinds.kind import Kind

_FAMILIES = (
    lab.KINDS,
    joystick.KINDS,
    appliances.KINDS,
    desk.KINDS,
    office.KINDS,
    store.KINDS,
    cash.KINDS,
    slot.KINDS,
    street.KINDS,
    vending.KINDS,
    car.KINDS,
    nameless.KINDS,
)

CATALOGUE: dict[str, Kind] = {kind.name: kind for family in _FAMILIES for kind in family}
"""Every kind by its name."""
