# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The safety gate between the mission and the robot: what is wrong maps to an action, and the worst action wins.

It is stepped at a steady pace, whether commands come or not, and reads no clock. It is no certified safety system.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Iterable, NamedTuple

from edgefusion.config import BaseConfig, SafetyConfig
from edgefusion.navigation.braking import stoppable_speed
from edgefusion.navigation.deadman import Deadman
from edgefusion.types import Health, HealthState, Twist2D

_NS_PER_S = 1_000_000_000


class Action(IntEnum):
    """What becomes of a command; of several, the worst wins."""

    RUN = 0
    """It passes."""
    CAP = 1
    """It is slowed down, on the same arc."""
    STOP = 2
    """Zero, for as long as the cause lasts and until what was missing has come again."""
    STOP_LATCHED = 3
    """Zero, until an operator resumes."""


class Finding(NamedTuple):
    """Something that is not as it should be, what it demands, and its words: the same for as long as it lasts."""

    action: Action
    reason: str


class Stamps(NamedTuple):
    """When the newest of each was captured, and the command computed; None where there is none yet."""

    scan_ns: int | None = None
    odometry_ns: int | None = None
    detections_ns: int | None = None
    command_ns: int | None = None


class Decision(NamedTuple):
    """What goes to the robot, once it is in what the wire carries (law.as_carried): slowing gives fractions.

    findings: all that is not as it should be, the worst first.
    """

    action: Action
    twist: Twist2D
    findings: tuple[Finding, ...]

    @property
    def reason(self) -> str:
        """The findings in words, for log and viewer alike."""
        return "; ".join(finding.reason for finding in self.findings)


class SafetyGate:
    """Passes commands on while everything that they rest on is fresh and well. It starts in STOP."""

    def __init__(self, safety: SafetyConfig, base: BaseConfig) -> None:
        self._safety, self._base = safety, base
        # In the order of Stamps.
        self._watched = (
            (Deadman("scan", _ns(safety.max_scan_age_s), safety.good_scans), Action.STOP),
            (Deadman("odometry", _ns(safety.max_odometry_age_s)), Action.STOP),
            (Deadman("detections", _ns(safety.max_detections_age_s)), Action.RUN),
            (Deadman("command", _ns(safety.max_command_age_s)), Action.STOP),
        )
        self._last_ns: int | None = None
        self._latched: Finding | None = None
        self._over_limit = 0
        self._over_limit_ns: int | None = None

    @property
    def over_limit(self) -> int:
        """How many commands were faster than the base may go, each counted once."""
        return self._over_limit

    def step(self, now_ns: int, health: Iterable[Health], stamps: Stamps, command: Twist2D) -> Decision:
        """One cycle. health: the newest report of every component; command: the one of stamps.command_ns."""
        findings = [
            *self._cycle(now_ns),
            *self._ages(now_ns, stamps),
            *judge_health(tuple(health), self._safety),
        ]
        self._latch(findings)
        if self._latched and self._latched not in findings:
            findings.append(self._latched)
        slowing, twist = self._slowed(now_ns, stamps, command)
        findings = sorted(findings + slowing, key=lambda finding: -finding.action)
        action = max((finding.action for finding in findings), default=Action.RUN)
        return Decision(action, twist if action < Action.STOP else Twist2D(), tuple(findings))

    def stop(self, reason: str) -> None:
        """An operator's stop: STOP_LATCHED from the next step on."""
        self._latch([Finding(Action.STOP_LATCHED, reason)])

    def resume(self) -> None:
        """An operator's leave to move again, once the cause is gone: where it is not, the next step latches anew.

        What came before no longer counts: neither commands nor scans.
        """
        if self._latched:
            self._latched = None
            self._restart()

    def _latch(self, findings: Iterable[Finding]) -> None:
        """Keeps the first cause; those that come later are found as long as they last."""
        for finding in findings:
            if finding.action is Action.STOP_LATCHED and self._latched is None:
                self._latched = finding

    def _cycle(self, now_ns: int) -> list[Finding]:
        """Whether this step comes in time. After one that does not, nothing is trusted that came before."""
        last_ns, self._last_ns = self._last_ns, now_ns
        if last_ns is None:
            return [Finding(Action.STOP, "cycle: the first")]
        if 0 <= now_ns - last_ns <= _ns(self._safety.max_cycle_s):
            return []
        self._restart()
        return [Finding(Action.STOP, f"cycle: not within {self._safety.max_cycle_s:g} s of the last")]

    def _restart(self) -> None:
        for deadman, _ in self._watched:
            deadman.restart()

    def _ages(self, now_ns: int, stamps: Stamps) -> list[Finding]:
        """Steps every deadman, whatever the others say: each must keep count."""
        faults = [(action, deadman.step(now_ns, ns)) for (deadman, action), ns in zip(self._watched, stamps)]
        return [Finding(action, fault) for action, fault in faults if fault]

    def _slowed(self, now_ns: int, stamps: Stamps, command: Twist2D) -> tuple[list[Finding], Twist2D]:
        """The command within the base's limits, and within what the scan's age permits."""
        base, findings = self._base, []
        twist = _scaled(command, base.max_speed_mps, base.max_yaw_rate_radps)
        if twist != command:
            self._count_over_limit(stamps.command_ns)
            findings.append(Finding(Action.CAP, "command: faster than the base may go"))
        if stamps.scan_ns is not None and stamps.scan_ns <= now_ns:
            age_s = (now_ns - stamps.scan_ns) / _NS_PER_S
            permitted_mps = permitted_speed_mps(age_s, self._safety, base)
            if abs(twist.v_mps) > permitted_mps:
                twist = _scaled(twist, permitted_mps, base.max_yaw_rate_radps)
                findings.append(Finding(Action.CAP, "scan: too old for this speed"))
        return findings, twist

    def _count_over_limit(self, command_ns: int | None) -> None:
        if command_ns != self._over_limit_ns:
            self._over_limit, self._over_limit_ns = self._over_limit + 1, command_ns


def permitted_speed_mps(scan_age_s: float, safety: SafetyConfig, base: BaseConfig) -> float:
    """So fast that the scan's age, a cycle, the command's delay and braking fit into the stopping room."""
    blind_s = scan_age_s + safety.cycle_s + base.command_delay_s
    return stoppable_speed(safety.stopping_room_m, blind_s, base.acceleration_mps2)


def judge_health(reports: tuple[Health, ...], safety: SafetyConfig) -> list[Finding]:
    """What the components' reports demand, and the lack of one that is required."""
    findings = [
        Finding(_demanded(report, safety), f"{report.component}: {report.reason}")
        for report in reports
        if report.state is not HealthState.OK
    ]
    missing = [name for name in safety.required if name not in {report.component for report in reports}]
    return findings + [Finding(Action.STOP, f"{name}: no report yet") for name in missing]


def _demanded(report: Health, safety: SafetyConfig) -> Action:
    if report.state is HealthState.DEGRADED or report.component in safety.optional:
        return Action.RUN
    if report.state is HealthState.FAILED and report.component in safety.latching:
        return Action.STOP_LATCHED
    return Action.STOP


def _scaled(twist: Twist2D, max_speed_mps: float, max_yaw_rate_radps: float) -> Twist2D:
    """Slowed down to the limits as a whole: on another arc there might be an obstacle."""
    share = max(abs(twist.v_mps) / max_speed_mps, abs(twist.w_radps) / max_yaw_rate_radps)
    return twist if share <= 1 else Twist2D(twist.v_mps / share, twist.w_radps / share)


def _ns(seconds: float) -> int:
    return round(seconds * _NS_PER_S)
