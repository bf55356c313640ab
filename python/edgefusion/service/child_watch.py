# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a supervisor knows of one child, and what becomes of it. Pure: told what happens, and when."""

from __future__ import annotations

import signal
from collections import deque
from contextlib import suppress
from enum import Enum
from typing import Any, Deque, Dict, Mapping

from edgefusion.drivers.backoff import Backoff
from edgefusion.service.child_spec import ChildSpec
from edgefusion.types import Health, HealthState

STEADY_NS = 10_000_000_000
"""Who lived for so long begins its pauses anew."""

REFUSED = 2
"""The exit code of a command whose input was refused: it would be again."""


class State(Enum):
    """KILLED: it was sent SIGKILL, and is not gone yet. STOPPING: it is gone, its robot is being stopped."""

    WAITING = "waiting"
    STARTING = "starting"
    RUNNING = "running"
    KILLED = "killed"
    STOPPING = "stopping"
    GIVEN_UP = "given up"
    ENDED = "ended"


UP = (State.STARTING, State.RUNNING)


class ChildWatch:
    """state: of the child now. reason: why it failed last. status: what it said last.

    line_status: what it said last that names a robot's port, in any of its lives. lived: whether it was heard in any of
    them. refused: it never lived, and ended as commands do that refuse their input. gives_up: it is not to be started
    again.
    """

    def __init__(self, spec: ChildSpec) -> None:
        self.spec, self.state = spec, State.WAITING
        self.reason = ""
        self.status: Dict[str, Any] = {}
        self.line_status: Dict[str, Any] = {}
        self.lived = self.refused = self.gives_up = False
        self._backoff = Backoff(round(spec.first_pause_s * 1e9), round(spec.longest_pause_s * 1e9))
        self._failures_ns: Deque[int] = deque()
        self._started_ns = self._heard_ns = 0

    @property
    def stopped(self) -> str:
        """Why an operator has stopped its robot, in whichever of its lives, and has not resumed."""
        return str(self.line_status.get("stopped", ""))

    def is_due(self, now_ns: int) -> bool:
        """Whether it is to be started."""
        return self.state is State.WAITING and self._backoff.due(now_ns)

    def started(self, now_ns: int) -> None:
        self.state, self.status = State.STARTING, {}
        self._started_ns = self._heard_ns = now_ns

    def beat(self, now_ns: int, status: Mapping[str, Any]) -> None:
        """It lives, and says how it is."""
        self.status = dict(status)
        if "port" in self.status:
            self.line_status = self.status
        if self.state is State.STARTING:
            self.state = State.RUNNING
        self.lived, self._heard_ns = True, now_ns

    def forgive(self, now_ns: int, gap_ns: int) -> None:
        """For so long nobody listened: that is not its silence."""
        self._heard_ns = min(now_ns, self._heard_ns + gap_ns)

    def silence(self, now_ns: int) -> str:
        """Why it is taken for dead, in words; empty while it is not."""
        if self.state not in UP:
            return ""
        starts = self.state is State.STARTING
        limit_s = self.spec.start_s if starts else self.spec.silence_s
        if now_ns - self._heard_ns <= limit_s * 1e9:
            return ""
        return f"no sign of life within {limit_s:g} s of its start" if starts else f"silent for {limit_s:g} s"

    def kill(self, reason: str) -> None:
        """It is sent SIGKILL."""
        self.state, self.reason = State.KILLED, reason

    def failed(self, now_ns: int, reason: str, code: int | None = None) -> None:
        """It is gone, though nobody asked it to end. reason: where it was not killed for another."""
        if self.state is not State.KILLED:
            self.reason = reason
        self.refused = code == REFUSED and not self.lived
        if self.lived and self._heard_ns - self._started_ns >= STEADY_NS:
            self._backoff.reset()
        self._backoff.failed(now_ns)
        self._count(now_ns)
        self.state = State.STOPPING if self.spec.drives else self._rest

    def end(self) -> None:
        """It is gone, or will not be started any more; one that was given up stays so."""
        if self.state is not State.GIVEN_UP:
            self.state = State.ENDED

    def robot_stopped(self) -> None:
        """Nothing is in the way of its next start."""
        if self.state is State.STOPPING:
            self.state = self._rest

    def health(self) -> Health:
        """For the other children, and for people."""
        name, reason = self.spec.name, self.reason
        if self.state is State.RUNNING:
            return Health(name, HealthState.OK)
        if self.state is State.GIVEN_UP:
            return Health(name, HealthState.FAILED, f"given up after {len(self._failures_ns)} failures: {reason}")
        if self.state is State.ENDED:
            return Health(name, HealthState.FAILED, "ended")
        if self.state is State.STARTING or not reason:
            return Health(name, HealthState.STARTING, f"starts again after: {reason}" if reason else "starts")
        return Health(name, HealthState.FAILED, reason)

    def in_words(self) -> str:
        """How it is, and what it says it does."""
        health = self.health()
        detail = health.reason or str(self.status.get("says", ""))
        return f"{health.component} {health.state.value}" + (f": {detail}" if detail else "")

    @property
    def _rest(self) -> State:
        return State.GIVEN_UP if self.gives_up else State.WAITING

    def _count(self, now_ns: int) -> None:
        limit = self.spec.give_up
        if limit is None:
            return
        self._failures_ns.append(now_ns)
        while now_ns - self._failures_ns[0] > limit.within_s * 1e9:
            self._failures_ns.popleft()
        self.gives_up = len(self._failures_ns) >= limit.failures


def how_it_ended(code: int) -> str:
    """A process' exit code in words, as Popen gives it."""
    if code >= 0:
        return f"ended with exit code {code}"
    with suppress(ValueError):
        return f"killed by {signal.Signals(-code).name}"
    return f"killed by signal {-code}"
