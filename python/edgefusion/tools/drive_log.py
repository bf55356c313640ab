# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What happened on a drive: where the base was, what the mission did, what the safety gate did."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from edgefusion.navigation.inspection_result import InspectionResult
from edgefusion.navigation.mission_step import MissionState, MissionStep
from edgefusion.navigation.safety import Action, Decision
from edgefusion.types import Pose2D


class Moment(NamedTuple):
    """Where the base is, and where it believes to be, both in the world."""

    stamp_ns: int
    pose: Pose2D
    believed: Pose2D


class Event(NamedTuple):
    """Something that the mission did, in words, and where the base believed to be then, in the world."""

    stamp_ns: int
    what: str
    believed: Pose2D


@dataclass
class Spell:
    """A time in which the gate found the same things wrong. until_ns: of the first decision that is another."""

    action: Action
    reason: str
    from_ns: int
    until_ns: int


class DriveLog:
    """Told of every tick of a drive; all of it fills up as it goes. decisions: the gate's, by what they came to."""

    def __init__(self) -> None:
        self.trail: list[Moment] = []
        self.events: list[Event] = []
        self.inspections: list[InspectionResult] = []
        self.spells: list[Spell] = []
        self.decisions: Counter[Action] = Counter()
        self._doing = ""

    def was_at(self, moment: Moment) -> None:
        self.trail.append(moment)

    def stepped(self, step: MissionStep) -> None:
        """A step of the mission, at the last moment."""
        if step.result is not None:
            self.inspections.append(step.result)
            self._add(f"inspected, {'no picture: ' + step.result.reason if step.result.reason else 'has a picture'}")
        doing = _doing(step)
        if doing != self._doing:
            self._doing = doing
            self._add(doing)
        if step.request is not None:
            self._add(f"asks for a picture: {step.request.label}")

    def decided(self, decision: Decision) -> None:
        """A decision of the gate, at the last moment."""
        now_ns = self.trail[-1].stamp_ns
        self.decisions[decision.action] += 1
        if self.spells and self.spells[-1].until_ns < 0:
            last = self.spells[-1]
            if (last.action, last.reason) == (decision.action, decision.reason):
                return
            last.until_ns = now_ns
        if decision.findings:
            self.spells.append(Spell(decision.action, decision.reason, now_ns, -1))

    def ended(self) -> None:
        """At the last moment."""
        for spell in self.spells:
            if spell.until_ns < 0:
                spell.until_ns = self.trail[-1].stamp_ns

    def _add(self, what: str) -> None:
        moment = self.trail[-1]
        self.events.append(Event(moment.stamp_ns, what, moment.believed))


def _doing(step: MissionStep) -> str:
    """A driving robot's notes come and go with every obstacle: left out."""
    if step.state is MissionState.INSPECTING:
        return f"{step.state.value}, {step.note}"
    return f"{step.state.value}: {step.reason}" if step.reason else step.state.value
