# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Of the velocity that is wished for, what may be driven: slower, then straighter, until the guard lets it pass."""

from __future__ import annotations

import math
from typing import Iterator

from edgefusion.navigation.drive_model import Motion
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Twist2D

_SLOWER = (1.0, 0.85, 0.7, 0.55, 0.4, 0.3, 0.2, 0.1, 0.0)
_STRAIGHTER = (1.0, 0.5, 0.0)


def as_carried(twist: Twist2D) -> Twist2D:
    """In whole mm/s and deg/s, as the wire carries it."""
    v_mps = int(twist.v_mps * 1000) / 1000
    return Twist2D(v_mps, math.radians(round(math.degrees(twist.w_radps))))


def permitted(surroundings: Surroundings, motion: Motion, wish: Twist2D, hold_s: float) -> Twist2D | None:
    """The wish or what is left of it; None where only standing is."""
    for twist in _lesser(wish):
        if surroundings.guard.free(surroundings.map, motion, twist.v_mps, twist.w_radps, hold_s):
            return twist
    return None


def _lesser(wish: Twist2D) -> Iterator[Twist2D]:
    tried = {Twist2D()}
    for straighter in _STRAIGHTER:
        for slower in _SLOWER:
            twist = as_carried(Twist2D(slower * wish.v_mps, straighter * wish.w_radps))
            if twist not in tried:
                tried.add(twist)
                yield twist
