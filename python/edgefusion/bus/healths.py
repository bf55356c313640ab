# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How the robot's components are, as each of its processes says it of its own."""

from __future__ import annotations

from typing import Dict, NamedTuple, Tuple

import zenoh

from edgefusion.bus.reader import Reader
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.topics import DIAGNOSTICS, key_of
from edgefusion.clock import Clock
from edgefusion.messages.to_healths import Report, to_healths
from edgefusion.types import Health, HealthState

SILENT_NS = 3_000_000_000
"""States are said twice a second: a component of which nothing was heard for so long cannot be well."""

NEWEST = 32


class _Heard(NamedTuple):
    report: Report
    received_ns: int


class Healths:
    """What was last said of each component, from when it is made on."""

    def __init__(self, session: zenoh.Session, robot: str, clock: Clock) -> None:
        self._clock, self._reader = clock, Reader(DIAGNOSTICS, to_healths)
        self._subscriber = Subscriber(session, key_of(robot, DIAGNOSTICS.name), NEWEST, clock=clock)
        self._heard: Dict[str, _Heard] = {}

    @property
    def reports(self) -> Tuple[Report, ...]:
        """By component. One of which nothing was heard for long has failed. Malformed messages are left out."""
        for received in self._subscriber.take():
            for report in self._reader.read(received.payload) or ():
                self._heard[report.health.component] = _Heard(report, received.received_ns)
        now_ns = self._clock()
        return tuple(_now(heard, now_ns) for _, heard in sorted(self._heard.items()))


def _now(heard: _Heard, now_ns: int) -> Report:
    silent_ns = now_ns - heard.received_ns
    if silent_ns < SILENT_NS:
        return heard.report
    reason = f"nothing heard for {silent_ns / 1e9:.0f} s"
    return Report(Health(heard.report.health.component, HealthState.FAILED, reason), {})
