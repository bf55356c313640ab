# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a supervisor does about its children: when to start, kill and give up which, and how all of it ends.

Pure: it is told what happened, and when, and says what to do about it. A child that drives is started again only after
its robot was told to stop.
"""

from __future__ import annotations

import logging
import signal
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from edgefusion.errors import RefusedError
from edgefusion.service.child_spec import ChildSpec
from edgefusion.service.child_watch import REFUSED, UP, ChildWatch, State, how_it_ended
from edgefusion.service.supervision_actions import Action, Send, Start, StopRobot
from edgefusion.types import Health

GRACE_NS = 1_800_000_000
"""Whoever was asked to end and has not by then is killed."""

END_NS = 2_800_000_000
"""From when it was to end until it has, come what may."""

LATE_NS = 500_000_000
"""Who comes by so late was not there to listen."""

_GONE = (State.ENDED, State.GIVEN_UP)
_LOG = logging.getLogger(__name__)


class Supervision:
    """To be told everything by one thread."""

    def __init__(self, specs: Sequence[ChildSpec]) -> None:
        self._children: Dict[str, ChildWatch] = {spec.name: ChildWatch(spec) for spec in specs}
        if len(self._children) != len(specs):
            raise RefusedError(f"children: expected each name once, got {', '.join(spec.name for spec in specs)}")
        self._actions: List[Action] = []
        self._stepped_ns: int | None = None
        self._ending_ns: int | None = None
        self._exit_code = 0

    @property
    def ending(self) -> bool:
        return self._ending_ns is not None

    @property
    def ready(self) -> bool:
        """Whether all children that are required have shown that they live."""
        return all(child.lived or not child.spec.required for child in self._children.values())

    def healths(self) -> Tuple[Health, ...]:
        """Of all children, in their order."""
        return tuple(child.health() for child in self._children.values())

    def in_words(self) -> str:
        """All of them in one line, for people."""
        return "; ".join(child.in_words() for child in self._children.values())

    def has_ended(self, now_ns: int) -> bool:
        """Whether nothing is left to wait for."""
        if self._ending_ns is None:
            return False
        late = now_ns - self._ending_ns >= END_NS
        return late or all(child.state in _GONE for child in self._children.values())

    @property
    def exit_code(self) -> int:
        """Once it has ended: 0 as asked; 1 a required child was given up, one does not end, or nobody knows whether the
        robot stopped; 2 a required child refused to start."""
        return self._exit_code or int(any(child.state not in _GONE for child in self._children.values()))

    def started(self, now_ns: int, name: str) -> None:
        self._children[name].started(now_ns)

    def not_started(self, now_ns: int, name: str, reason: str) -> None:
        """Its command cannot be run. There is no robot to be stopped."""
        child = self._children[name]
        child.failed(now_ns, reason)
        child.robot_stopped()
        self._tell_failure(now_ns, child)

    def beat(self, now_ns: int, name: str, status: Mapping[str, Any]) -> None:
        """A sign of life."""
        child = self._children[name]
        if child.state is State.STARTING:
            _LOG.info("%s: started", name)
        child.beat(now_ns, status)

    def exited(self, now_ns: int, name: str, code: int) -> None:
        """A child is gone. code: as Popen says it, negative for a signal."""
        child = self._children[name]
        if self._ending_ns is None:
            child.failed(now_ns, how_it_ended(code), code)
            self._stop_robot(child, None)
            self._tell_failure(now_ns, child)
        elif child.spec.drives and code != 0:
            _LOG.warning("%s: %s when it was to end", name, how_it_ended(code))
            child.state = State.STOPPING
            self._stop_robot(child, self._ending_ns + END_NS)
        else:
            child.end()

    def robot_stopped(self, name: str, stopped: bool) -> None:
        """What the child left behind was told to stop, or nobody knows."""
        child = self._children[name]
        if child.state is not State.STOPPING:
            return
        child.robot_stopped()
        if self._ending_ns is not None:
            child.end()
            self._exit_code = self._exit_code or int(not stopped)

    def end(self, now_ns: int, reason: str, exit_code: int = 0) -> None:
        """All children are asked to end, and killed when they do not. Once; a second time changes nothing."""
        if self._ending_ns is not None:
            return
        _LOG.log(logging.ERROR if exit_code else logging.INFO, "ends: %s", reason)
        self._ending_ns, self._exit_code = now_ns, exit_code
        for name, child in self._children.items():
            if child.state in UP:
                self._actions.append(Send(name, signal.SIGTERM))
            elif child.state is State.WAITING:
                child.end()

    def step(self, now_ns: int) -> Sequence[Action]:
        """What is to be done now. To be called a few times a second, after all that happened was told."""
        self._forgive(now_ns)
        if self._ending_ns is None:
            for child in self._children.values():
                self._look_at(child, now_ns)
        elif now_ns - self._ending_ns >= GRACE_NS:
            for child in self._children.values():
                if child.state in UP:
                    self._kill(child, "does not end")
        actions, self._actions = self._actions, []
        return actions

    def _look_at(self, child: ChildWatch, now_ns: int) -> None:
        if child.is_due(now_ns):
            self._actions.append(Start(child.spec, child.stopped))
        silence = child.silence(now_ns)
        if silence:
            self._kill(child, silence)

    def _kill(self, child: ChildWatch, reason: str) -> None:
        _LOG.warning("%s: %s; killed", child.spec.name, reason)
        child.kill(reason)
        self._actions.append(Send(child.spec.name, signal.SIGKILL))

    def _stop_robot(self, child: ChildWatch, by_ns: int | None) -> None:
        if child.state is State.STOPPING:
            self._actions.append(StopRobot(child.spec.name, child.line_status, by_ns))

    def _tell_failure(self, now_ns: int, child: ChildWatch) -> None:
        health, name = child.health(), child.spec.name
        _LOG.log(logging.ERROR if child.spec.required else logging.WARNING, "%s: %s", name, health.reason)
        if not child.spec.required:
            return
        if child.refused:
            self.end(now_ns, f"{name} refused to start", REFUSED)
        elif child.gives_up:
            self.end(now_ns, f"{name} was given up", 1)

    def _forgive(self, now_ns: int) -> None:
        gap_ns = 0 if self._stepped_ns is None else now_ns - self._stepped_ns
        self._stepped_ns = now_ns
        if gap_ns > LATE_NS:
            _LOG.warning("supervisor: was late by %.1f s", gap_ns / 1e9)
            for child in self._children.values():
                child.forgive(now_ns, gap_ns)
