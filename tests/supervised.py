# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A supervision whose children are imaginary, in virtual time."""

from __future__ import annotations

import signal
from dataclasses import replace
from typing import Any, Sequence

from edgefusion.clock import SimClock
from edgefusion.service.child_spec import ChildSpec, GiveUp
from edgefusion.service.supervision import Supervision
from edgefusion.service.supervision_actions import Action, Send, Start

MS = 1_000_000
S = 1_000_000_000
TURN_NS = 50 * MS
LINE = {"port": "/dev/ttyUSB0", "baudrate": 38400}
BUS = ChildSpec("bus", ("bus",), 10.0, 3.0)
BASE = ChildSpec("base", ("base",), 10.0, 1.5, drives=True)
VISION = ChildSpec("vision", ("vision",), 60.0, 4.0, GiveUp(5, 60.0), required=False)
REQUIRED_VISION = replace(VISION, required=True)


class Supervised:
    """Its children start at once, beat in every turn, obey SIGTERM, and robots stop at once, but for those that a test
    names in: deaf (do not end), silent, stuck (their robot's stop takes for ever), missing (cannot be started).

    done: what was to be done, and when. up: who runs. story: of base: its lives, and the stops of its robot.
    """

    def __init__(self, *specs: ChildSpec, missing: Sequence[str] = ()) -> None:
        self.clock = SimClock(S)
        self.supervision = Supervision(specs or (BUS, BASE, VISION))
        self.done: list[tuple[float, Action]] = []
        self.up: list[str] = []
        self.deaf: set[str] = set()
        self.silent: set[str] = set()
        self.stuck: set[str] = set()
        self.missing: set[str] = set(missing)
        self.story: list[str] = []
        self.statuses: dict[str, dict[str, Any]] = {"base": LINE}
        self.robot_stops = True
        self.turn(0)

    @property
    def now_s(self) -> float:
        return self.clock() / S

    def turn(self, ns: int = TURN_NS) -> None:
        now_ns = self.clock.advance(ns)
        for name in self.up:
            if name not in self.silent:
                self.supervision.beat(now_ns, name, self.statuses.get(name, {}))
        for action in self.supervision.step(now_ns):
            self.done.append((self.now_s, action))
            self._do(action, now_ns)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * S / TURN_NS)):
            self.turn()

    def until_it_ends(self) -> float:
        """How long it takes [s]."""
        begin_s = self.now_s
        while not self.supervision.has_ended(self.clock()):
            assert self.now_s - begin_s < 30
            self.turn()
        return self.now_s - begin_s

    def die(self, name: str, code: int = -signal.SIGKILL) -> None:
        self.up.remove(name)
        self.supervision.exited(self.clock(), name, code)

    def starts(self, name: str) -> list[float]:
        """When it was started [s]."""
        return [s for s, action in self.done if isinstance(action, Start) and action.spec.name == name]

    def since(self, seconds: float) -> list[Action]:
        """What was to be done from then on."""
        return [action for s, action in self.done if s >= seconds]

    def health(self, name: str):
        return next(health for health in self.supervision.healths() if health.component == name)

    def _do(self, action: Action, now_ns: int) -> None:
        if isinstance(action, Start):
            self._start(action.spec.name, now_ns)
        elif isinstance(action, Send):
            if action.name in self.up and (action.number == signal.SIGKILL or action.name not in self.deaf):
                self.die(action.name, 0 if action.number == signal.SIGTERM else -action.number)
        else:
            self._stop(action.name)

    def _stop(self, name: str) -> None:
        self.story.append("stop")
        if name not in self.stuck:
            self.supervision.robot_stopped(name, self.robot_stops)

    def _start(self, name: str, now_ns: int) -> None:
        if name in self.missing:
            self.supervision.not_started(now_ns, name, "cannot be run")
        else:
            self.supervision.started(now_ns, name)
            self.up.append(name)
            self.story += ["life"] if name == "base" else []
