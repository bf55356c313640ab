# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How fast something may move that must be able to stop in time."""

from __future__ import annotations

import math


def stoppable_speed(room: float, blind_s: float, braking: float) -> float:
    """The speed from which it stops within `room`, of which it crosses a part for `blind_s` before it brakes.

    In metres, m/s and m/s^2, or in radians, rad/s and rad/s^2. 0 where there is no room. It solves
    speed * blind_s + speed^2 / (2 braking) = room.
    """
    slack, gained = braking * blind_s, 2 * braking * max(room, 0.0)
    return gained / (slack + math.sqrt(slack * slack + gained)) if gained else 0.0
