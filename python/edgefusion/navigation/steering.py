# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Of the velocity that is wished for, what may be driven: slower, then straighter, until the guard lets it pass."""

from __future__ import annotations

from typing import Iterable, Iterator

from edgefusion.navigation.drive_model import Motion
from edgefusion.navigation.law import CYCLE_S, as_carried
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Twist2D

CLOSE = 0.5
"""Of the margin is kept by manoeuvres, which are slow, and planned with a little more (manoeuvring.PLANNED)."""

YIELDS_S = 2.0
"""The robot does not stop where somebody will come by within this time."""

_SLOWER = (1.0, 0.85, 0.7, 0.55, 0.4, 0.3, 0.2, 0.1, 0.0)
_STRAIGHTER = (1.0, 0.5, 0.0)


class Steering:
    """Asks the guard about commands for where the next one takes effect. hold_s: how long it is taken to last."""

    def __init__(self, surroundings: Surroundings, margin_m: float, motion: Motion, hold_s: float) -> None:
        self._surroundings, self._motion, self._hold_s = surroundings, motion, hold_s
        self._margin_m = margin_m

    def permitted(self, wish: Twist2D) -> Twist2D:
        """The wish, or what is left of it; zero where only standing is."""
        if self._surroundings.guard.stirs:
            return self._yielding(wish)
        return self._first(_lesser(wish), self._margin_m) or Twist2D()

    def along(self, wish: Twist2D) -> Twist2D:
        """The same on the wish's own arc and closely, for a manoeuvre that was tried with the hull."""
        shares = (_scaled(wish, share, share) for share in (1.0, 0.6, 0.3))
        return self._first(shares, CLOSE * self._margin_m) or Twist2D()

    def _yielding(self, wish: Twist2D) -> Twist2D:
        """Where somebody walks about the robot does not stop in his way, if it can stop anywhere else."""
        twist = self._first(_lesser(wish), self._margin_m, YIELDS_S)
        if twist is not None or self._first([Twist2D()], self._margin_m, YIELDS_S) is not None:
            return twist or Twist2D()
        return self._first(_lesser(wish), self._margin_m) or Twist2D()

    def _first(self, twists: Iterable[Twist2D], margin_m: float, linger_s: float = 0.0) -> Twist2D | None:
        guard, seen = self._surroundings.guard, self._surroundings.map
        for twist in twists:
            v_mps, w_radps = twist.v_mps, twist.w_radps
            # It may end after one cycle, or last for longer.
            if all(
                guard.free(seen, self._motion, v_mps, w_radps, hold_s, margin_m, linger_s)
                for hold_s in (self._hold_s, CYCLE_S)
            ):
                return twist
        return None


def _scaled(wish: Twist2D, v_share: float, w_share: float) -> Twist2D:
    return as_carried(Twist2D(v_share * wish.v_mps, w_share * wish.w_radps))


def _lesser(wish: Twist2D) -> Iterator[Twist2D]:
    """All but the standstill, each once."""
    tried = {Twist2D()}
    for straighter in _STRAIGHTER:
        for slower in _SLOWER:
            twist = _scaled(wish, slower, straighter)
            if twist not in tried:
                tried.add(twist)
                yield twist
