# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What people want of the robot, made so in the base's loop: the mission's goals, their own driving, and their stops.

It has no clock or thread: all of it is the loop's, between two steps.
"""

from __future__ import annotations

import logging
from typing import Callable

from edgefusion.bus.arbiter import Arbiter, Driver
from edgefusion.bus.requests import GotoRequest, InspectRequest, StopRequest
from edgefusion.errors import RefusedError
from edgefusion.messages.to_goal_pose import GoalPose
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.goal_requests import goals_of
from edgefusion.types import Goal, Twist2D

OPERATOR_DRIVES = "an operator drives"

log = logging.getLogger(__name__)


class Helm:
    """refused_goals: how many a `goal_pose` brought that the robot does not drive to. stopped: called when somebody has
    stopped it, before they are answered."""

    def __init__(self, loop: BaseLoop, arbiter: Arbiter, stopped: Callable[[], object] = lambda: None) -> None:
        self._loop, self._arbiter, self._stopped = loop, arbiter, stopped
        self._poses = 0
        self.refused_goals = 0

    def goto(self, request: GotoRequest) -> None:
        """Raises RefusedError, and changes nothing, while the robot may not be driven, and for goals that are none."""
        self._loop.goto(goals_of(request, self._loop.pose))
        if request.inspect is not None:
            self._loop.inspect(request.inspect)

    def goal_pose(self, goal: GoalPose) -> None:
        """Nobody waits for an answer: one that is refused is told in the log."""
        self._poses += 1
        try:
            if self._loop.pose is None:
                raise RefusedError("goal_pose: expected a robot that has reported, got none yet")
            self._loop.goto([Goal(f"goal_pose-{self._poses}", goal.in_odom(self._loop.pose))])
        except RefusedError as error:
            self.refused_goals += 1
            log.warning("%s", error)

    def stop(self, request: StopRequest) -> None:
        """For want of a reason nobody drives on."""
        reason = request.reason or StopRequest().reason
        self._arbiter.stop(reason)
        self._loop.stop(reason)
        if request.cancel:
            self._loop.cancel()
        self._stopped()

    def resume(self, now_ns: int) -> None:
        """Raises RefusedError where nothing was stopped, and without the operator who is required."""
        self._arbiter.resume(now_ns)
        self._loop.resume()

    def inspect(self, request: InspectRequest) -> None:
        """From now on."""
        self._loop.inspect(request.labels)

    def cmd_vel(self, received_ns: int, twist: Twist2D) -> None:
        self._arbiter.cmd_vel(received_ns, twist)
        self.twist(received_ns)  # the mission pauses now: a `resume` may be the next

    def heartbeat(self, received_ns: int) -> None:
        self._arbiter.heartbeat(received_ns)

    def twist(self, now_ns: int) -> Twist2D | None:
        """What to drive with now; None where the mission says it. To be asked in each cycle, right before it."""
        order = self._arbiter.decide(now_ns)
        if order.driver is Driver.NOBODY:
            self._loop.stop(order.reason)
        elif order.driver is Driver.OPERATOR:
            self._loop.pause(OPERATOR_DRIVES)
            return order.twist
        return None
