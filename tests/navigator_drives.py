# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Drives through the navigator's door in simulated floor plans, remembered step by step."""

from __future__ import annotations

import dataclasses
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.maze_shapes import box
from benchmarks.nav_run import TICK_NS, plan_spec

from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.progress import State
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.plan_simulation import PlanSimulation
from edgefusion.types import Goal, Pose2D, Twist2D

BASE = BaseConfig()
NAVIGATION = NavigationConfig()
KHATIB = NavigationConfig(field="khatib")
HERE = Pose2D()
OPEN = box((0.0, 0.0), 1000.0, 1000.0)
"""Open ground: no wall within reach of the laser."""

S = 1_000_000_000
ENDS = (State.ARRIVED, State.BLOCKED)


@dataclasses.dataclass(frozen=True)
class Step:
    """What was answered at a time, and what was true then."""

    stamp_ns: int
    twist: Twist2D
    progress: object
    odometry: Pose2D
    pose: Pose2D
    speed: Twist2D


class Drive:
    """A robot in a plan, driven step by step. Odometry begins at `start`. scan_of: what becomes of a scan on its way to
    the navigator, None before the first; rear_of: the rear sonar's points, by the true pose."""

    def __init__(self, plan, start=HERE, navigation=NAVIGATION, base=BASE, laser=None, seed=0, **options):
        spec = plan_spec(base, laser or LaserSpec(), **options)
        self.sim = PlanSimulation(plan, start, spec, seed)
        self.navigator = Navigator(navigation, base)
        self.steps = []
        self.scan_of = lambda scan: scan
        self.rear_of = lambda pose: None

    def step(self, goal):
        sim = self.sim
        scan, rear = self.scan_of(sim.newest_scan()), self.rear_of(sim.pose)
        twist, progress = self.navigator.step(sim.stamp_ns, scan, sim.odometry, goal, rear)
        self.steps.append(Step(sim.stamp_ns, twist, progress, sim.odometry, sim.pose, sim.twist))
        sim.command(twist)
        sim.step_to(sim.stamp_ns + TICK_NS)
        return progress

    def for_s(self, goal, seconds):
        """Goes on for so long, or until a contact."""
        for _ in range(round(seconds * S / TICK_NS)):
            self.step(goal)
            if self.sim.contact:
                break
        return self

    def until_end(self, goal, limit_s=60.0):
        """Goes on until the goal has ended, a contact, or the limit."""
        until_ns = self.sim.stamp_ns + limit_s * S
        while self.sim.stamp_ns < until_ns and not self.sim.contact:
            if self.step(goal).state in ENDS:
                break
        return self

    @property
    def last(self):
        return self.steps[-1].progress

    @property
    def twists(self):
        return [(step.twist.v_mps, step.twist.w_radps) for step in self.steps]

    def moved_m(self):
        path = np.array([(step.pose.x_m, step.pose.y_m) for step in self.steps])
        return float(np.hypot(*np.diff(path, axis=0).T).sum())


def goal_at(x_m, y_m, theta=0.0, name="goal", **tolerances):
    return Goal(name, Pose2D(x_m, y_m, theta), **tolerances)


def off(pose, goal):
    """How far a pose is from a goal's: metres and radians."""
    apart = pose.relative_to(goal.pose)
    return math.hypot(apart.x_m, apart.y_m), abs(apart.theta)


def is_at(pose, goal):
    apart_m, turn = off(pose, goal)
    return apart_m <= goal.position_tolerance_m and turn <= goal.heading_tolerance


def to_segments_m(points, segments):
    """Of points [n, 2] to the nearest of segments [m, 4]: float64[n]."""
    a, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    off_a = points[:, None, :] - a
    share = np.clip(np.sum(off_a * way, axis=-1) / np.sum(way * way, axis=-1), 0, 1)
    return np.linalg.norm(off_a - share[..., None] * way, axis=-1).min(axis=1)
