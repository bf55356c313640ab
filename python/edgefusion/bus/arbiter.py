# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who drives: the mission, an operator's cmd_vel, or nobody. Pure: the time is passed in.

A stop beats everything and is left only by `resume`. A cmd_vel pauses the mission until `resume`, and is followed for
as long as the deadman allows; then the robot stands. Where an operator is required, a heartbeat that fails is a stop.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Optional, Tuple

from edgefusion.errors import RefusedError
from edgefusion.types import Twist2D


class Driver(str, Enum):
    """Who drives."""

    MISSION = "mission"
    OPERATOR = "operator"
    NOBODY = "nobody"


@dataclass(frozen=True)
class Order:
    """twist: what to drive with; None where the mission says it. reason: why nobody drives."""

    driver: Driver
    twist: Optional[Twist2D]
    reason: str = ""


class Arbiter:
    """deadman_ns: so long a cmd_vel is followed. operator_timeout_ns: of the heartbeat; None: none is required."""

    def __init__(self, deadman_ns: int, operator_timeout_ns: Optional[int] = None) -> None:
        self._deadman_ns, self._operator_timeout_ns = deadman_ns, operator_timeout_ns
        self._stopped = ""  # why
        self._cmd_vel: Optional[Tuple[int, Twist2D]] = (
            None  # the last since resume, when it came; it pauses the mission
        )
        self._heartbeat_ns: Optional[int] = None

    def cmd_vel(self, received_ns: int, twist: Twist2D) -> None:
        """An operator's command came. While the robot is stopped it is worth nothing, then and later."""
        self._cmd_vel = received_ns, twist

    def heartbeat(self, received_ns: int) -> None:
        """An operator is there."""
        self._heartbeat_ns = received_ns

    def stop(self, reason: str) -> None:
        """Until `resume`; the first reason stays. Raises RefusedError for no reason."""
        if not reason:
            raise RefusedError("reason: expected why to stop, got nothing")
        self._stopped = self._stopped or reason

    def resume(self, now_ns: int) -> bool:
        """Leaves stop and pause, for the mission; gives whether there was one.

        Raises RefusedError, and leaves nothing, without the operator who is required.
        """
        missing = self._operator_missing(now_ns)
        if missing:
            raise RefusedError(f"resume: refused: {missing}")
        left = bool(self._stopped) or self._cmd_vel is not None
        self._stopped, self._cmd_vel = "", None
        return left

    def decide(self, now_ns: int) -> Order:
        """Who drives now."""
        missing = self._operator_missing(now_ns)
        if missing:
            self.stop(missing)
        if self._stopped:
            return Order(Driver.NOBODY, Twist2D(), self._stopped)
        if self._cmd_vel is None:
            return Order(Driver.MISSION, None)
        received_ns, twist = self._cmd_vel
        return Order(Driver.OPERATOR, twist if now_ns - received_ns <= self._deadman_ns else Twist2D())

    def _operator_missing(self, now_ns: int) -> str:
        """Why no operator counts as there; empty where one does, or none is required."""
        if self._operator_timeout_ns is None:
            return ""
        if self._heartbeat_ns is None:
            return "no operator has been there"
        silent_ns = now_ns - self._heartbeat_ns
        if silent_ns > self._operator_timeout_ns:
            return f"no heartbeat of an operator for {self._operator_timeout_ns / 1e9:g} s"
        return ""
