# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A drive through a simulated world: the mission drives it to its goal, past the safety gate, and vision watches."""

from __future__ import annotations

import math
from typing import Callable, Iterator

from edgefusion.config import Config
from edgefusion.navigation.law import as_carried
from edgefusion.navigation.mission import Mission
from edgefusion.navigation.mission_step import MissionState
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.safety import SafetyGate, Stamps
from edgefusion.perception.detector import Detector
from edgefusion.sim.hull import Hull, bounded
from edgefusion.sim.simulation import STEP_NS, Simulation
from edgefusion.tools.drive_log import DriveLog, Moment
from edgefusion.tools.look_pictures import LookPictures
from edgefusion.tools.vision import Look, Vision
from edgefusion.types import Goal, Health, HealthState, Scan, Twist2D

TICK_NS = 50_000_000
"""A command 20 times a second; the wheels begin to follow it at the next, as BaseConfig.command_delay_s has it."""

LONGEST_S = 600.0
"""Whatever happens, a drive is stopped then."""

WELL = (Health("robot", HealthState.OK), Health("laser", HealthState.OK), Health("camera", HealthState.OK))
"""Simulated devices do not fail."""

_ENDED = (MissionState.ARRIVED, MissionState.BLOCKED, MissionState.STOPPED)

Pacing = Callable[[int], None]
"""Is told the simulation's time at every tick; where somebody watches it waits until that is due."""


class Drive:
    """Goes through the drive look by look, to the world's goal; `log` and `clearance_m` follow.

    clearance_m: the smallest so far between the hull and the plan, inf where there is nothing, 0 at a contact, which
    ends the drive. way_m, way_left_m: straight to the goal, from the start and from here.
    """

    def __init__(
        self, simulation: Simulation, detector: Detector, pictures: LookPictures, config: Config, pace: Pacing
    ) -> None:
        world = simulation.world.world
        self._simulation, self._pace, self._start = simulation, pace, world.start
        self._goal = world.goal.relative_to(world.start)
        self._mission = Mission(config.mission, Navigator(config.navigation, config.base))
        self._mission.goto([Goal("goal", self._goal)])
        self._gate = SafetyGate(config.safety, config.base)
        self._vision = Vision(simulation, detector, config, pictures)
        self._hull, self._plan = Hull(config.base.footprint_m), bounded(simulation.world.plan.segments)
        self._scan: Scan | None = None
        self._sent = Twist2D()
        self._standing = False
        self.log, self.clearance_m = DriveLog(), math.inf
        self.way_m = self.way_left_m = math.hypot(self._goal.x_m, self._goal.y_m)

    @property
    def state(self) -> MissionState:
        """How it is going, and in the end how it went."""
        return self._mission.state

    @property
    def reason(self) -> str:
        """Of BLOCKED and STOPPED."""
        return self._mission.reason

    @property
    def pairing(self) -> dict[str, int]:
        """How many scans and frames ended how."""
        return self._vision.pairing

    @property
    def pictured(self) -> dict[str, str | None]:
        """Of every picture with its object in it, by the inspection's id, the thing in the world; None for a wall."""
        return self._vision.objects

    def __iter__(self) -> Iterator[Look]:
        """Drives until it has arrived, is blocked or is stopped: `state` says which."""
        while self.state not in _ENDED:
            yield from self._vision.look(self._scans(), self._standing)
            self._tick()
        self.log.ended()

    def _scans(self) -> list[Scan]:
        """Those that have come since the last time."""
        after_ns = -1 if self._scan is None else self._scan.stamp_ns
        scans = [self._simulation.scan(stamp_ns) for stamp_ns in self._simulation.scan_stamps(after_ns)]
        self._scan = scans[-1] if scans else self._scan
        return scans

    def _tick(self) -> None:
        """One command, and the time in which the last one is obeyed."""
        simulation = self._simulation
        now_ns, odometry = simulation.stamp_ns, simulation.odometry
        self.log.was_at(Moment(now_ns, simulation.pose, self._start.compose(odometry)))
        self.way_left_m = math.hypot(self._goal.x_m - odometry.x_m, self._goal.y_m - odometry.y_m)
        self._stop_where_it_must_end(now_ns)
        command = self._command(now_ns)
        simulation.command(self._sent)
        self._sent = command
        while simulation.stamp_ns < now_ns + TICK_NS:
            simulation.step_to(simulation.stamp_ns + STEP_NS)
            nearest_m = self._hull.clearance_m(simulation.pose, self._plan, self.clearance_m)
            self.clearance_m = min(self.clearance_m, nearest_m)
        self._pace(simulation.stamp_ns)

    def _command(self, now_ns: int) -> Twist2D:
        """What the gate lets through of what the mission wants."""
        odometry = self._simulation.odometry
        detections, answers = self._vision.arrived(now_ns)
        step = self._mission.step(now_ns, self._scan, odometry, detections, answers, sent=self._sent)
        if step.request is not None:
            self._vision.ask(step.request)
        self._standing = step.request is not None or (self._standing and step.result is None)
        scan_ns = None if self._scan is None else self._scan.stamp_ns
        stamps = Stamps(scan_ns, now_ns, self._vision.newest_ns, now_ns)
        decision = self._gate.step(now_ns, WELL, stamps, step.twist)
        self.log.stepped(step)
        self.log.decided(decision)
        return as_carried(decision.twist)  # slowing gives fractions

    def _stop_where_it_must_end(self, now_ns: int) -> None:
        if self.clearance_m == 0:
            self._mission.stop("contact")
        elif now_ns >= LONGEST_S * 1e9:
            self._mission.stop(f"not there within {LONGEST_S:g} s")
