# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The robot's end of the bus, as tests speak for it."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import zenoh

from bus_lab import Lab, until
from edgefusion.bus.freshness import CommandLimits, Freshness
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.queries import Service
from edgefusion.bus.requests import GotoRequest, InspectRequest, ResumeRequest, StopRequest
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import Topic
from edgefusion.errors import RefusedError
from edgefusion.messages import Message
from edgefusion.messages.mission_report import MissionReport
from edgefusion.messages.stamps import Stamper
from edgefusion.types import ClassScore, Cluster, Detection, Vote

LIMITS = CommandLimits(4096, 1e6, burst=100_000)
STAMPER = Stamper(1_700_000_000_000_000_000)
BEST = ClassScore(3, "oscilloscope", 0.9)
LISTENER_S = 60.0
"""A listener may be a process that has yet to start, on a busy machine."""

REQUESTS = {"mission/goto": GotoRequest, "stop": StopRequest, "resume": ResumeRequest, "inspect": InspectRequest}


def detection(stamp_ns: int, range_m: float = 2.0) -> Detection:
    return Detection(
        stamp_ns, 3, "oscilloscope", "instrument", 0.9, 0.4, (1, 2, 30, 40), range_m, 0.02, 0.1, (range_m, 0.2),
        Vote((BEST,), 0, 0.4, ((BEST,),)), ((1, 2, 30, 40),), Cluster(np.array([4, 5]), range_m, 0.1, 0.3), 5,
    )  # fmt: skip


class Speaker:
    """Says what it is told to, once somebody listens."""

    def __init__(self, session: zenoh.Session) -> None:
        self.session = session
        self._publishers = {}

    def say(self, topic: Topic, message: Message) -> None:
        publisher = self._publishers.get(topic)
        if publisher is None:
            publisher = self._publishers[topic] = Publisher(self.session, "robot", topic, Tagger(), "boot")
            until(lambda: publisher.wanted(time.monotonic_ns()), LISTENER_S)
        publisher.put(message, 0)


class Base(Speaker):
    """The robot's end of the bus: what it was asked is in `asked`; it refuses with `refusal`."""

    def __init__(self, lab: Lab) -> None:
        super().__init__(lab.member())
        self.asked, self.refusal = [], ""
        self._services = [
            Service(self.session, f"robot/{name}", kind, self._answer, Freshness(LIMITS), clock=lambda: 1000)
            for name, kind in REQUESTS.items()
        ]

    def _answer(self, request: Any) -> None:
        if self.refusal:
            raise RefusedError(self.refusal)
        self.asked.append(request)


def report(stamp_ns: int, state: Any, goal_id: str = "") -> MissionReport:
    return MissionReport(stamp_ns=stamp_ns, state=state, goal_id=goal_id)
