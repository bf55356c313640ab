# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What comes to the base over the bus: commands, which go to the helm, and what vision says, for the next step."""

from __future__ import annotations

from typing import Any, Dict, Mapping, NamedTuple, Tuple

import zenoh

from edgefusion.bus.feed import Feed
from edgefusion.bus.freshness import Freshness, limits_of
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.topics import CMD_VEL, DETECTIONS_DETAIL, GOAL_POSE, HEARTBEAT, INSPECTION_ANSWER
from edgefusion.clock import Clock, system_clock
from edgefusion.config import BusConfig
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.messages.to_goal_pose import to_goal_pose
from edgefusion.navigation.inspection_result import PictureAnswer
from edgefusion.service.helm import Helm
from edgefusion.service.picture_exchange import picture_answer
from edgefusion.types import Detection

KEPT = 8
"""Detections of so many frames, and so many answers, wait for a loop that is late."""


class FromVision(NamedTuple):
    """What came since the last step. detections_ns: the stamp of the newest frame so far."""

    detections: Tuple[Detection, ...] = ()
    detections_ns: int | None = None
    pictures: Tuple[PictureAnswer, ...] = ()


class BaseInbox:
    """clock_id: of the clock that stamps are of."""

    def __init__(self, session: zenoh.Session, config: BusConfig, clock_id: str, clock: Clock = system_clock) -> None:
        robot, limits = config.robot, limits_of(config)
        self._cmd_vel = Inbox(session, robot, CMD_VEL, to_cmd_vel, Freshness(limits), clock=clock)
        self._goal_pose = Inbox(session, robot, GOAL_POSE, to_goal_pose, Freshness(limits), clock=clock)
        self._heartbeat: Inbox[String] = Inbox(
            session, robot, HEARTBEAT, _as_it_is, Freshness(limits), clock, to_the_moment=True
        )  # else a loop that was late once would take its operator for gone
        self._detections = Feed(session, robot, DETECTIONS_DETAIL, to_detections_detail, clock_id, KEPT, clock=clock)
        self._pictures = Feed(session, robot, INSPECTION_ANSWER, picture_answer, clock_id, KEPT, clock=clock)
        self._detections_ns: int | None = None

    def command(self, helm: Helm, now_ns: int) -> None:
        """What people want. A heartbeat counts before what it comes with."""
        for received_ns, _ in self._heartbeat.take(now_ns):
            helm.heartbeat(received_ns)
        for received_ns, twist in self._cmd_vel.take(now_ns):
            helm.cmd_vel(received_ns, twist)
        for _, goal in self._goal_pose.take(now_ns):
            helm.goal_pose(goal)

    def from_vision(self) -> FromVision:
        """A frame that comes late does not make the newest older."""
        frames = [frame for _, frame in self._detections.take()]
        known_ns = [] if self._detections_ns is None else [self._detections_ns]
        self._detections_ns = max([*known_ns, *(frame.stamp_ns for frame in frames)], default=None)
        detections = tuple(detection for frame in frames for detection in frame.detections)
        return FromVision(detections, self._detections_ns, tuple(answer for _, answer in self._pictures.take()))

    def refused(self) -> Dict[str, str]:
        """How many commands and messages did not count, where there were any, and why."""
        inboxes: Mapping[str, Inbox[Any]] = {
            CMD_VEL.name: self._cmd_vel,
            GOAL_POSE.name: self._goal_pose,
            HEARTBEAT.name: self._heartbeat,
        }
        figures = {
            f"{name} refused, {why.value}": str(count)
            for name, inbox in inboxes.items()
            for why, count in dict(inbox.freshness.counts).items()
        }
        feeds: Mapping[str, Feed[Any]] = {
            DETECTIONS_DETAIL.name: self._detections,
            INSPECTION_ANSWER.name: self._pictures,
        }
        for name, feed in feeds.items():
            if feed.refused:
                figures[f"{name} refused"] = f"{feed.refused}: {feed.reason}"
        return figures


def _as_it_is(message: String) -> String:
    return message
