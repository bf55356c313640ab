# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated drive: how it can end, when commands are given, and what is simulated of a configured base."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.nav_pictures import draw_run
from benchmarks.nav_run import Outcome, drive, every, plan_spec

from edgefusion.config import BaseConfig
from edgefusion.navigation.progress import Progress, Reason, State
from edgefusion.sim.hull import Hull
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.plan_simulation import PlanSimulation
from edgefusion.types import Goal, Pose2D, Twist2D

BASE = BaseConfig(command_delay_s=0.0)
GOAL = Goal("goal", Pose2D(1.0, 0.0, 0.0))
WALL = np.array([[2.0, -3.0, 2.0, 3.0]])
AHEAD = Twist2D(0.4, 0.0)


class Straight:
    """Drives straight on, and is done with the goal after so many seconds."""

    def __init__(self, twist=AHEAD, done_s=math.inf, state=State.ARRIVED, reason=None):
        self.twist, self.done_s, self.state, self.reason = twist, done_s, state, reason
        self.stamps = []

    def step(self, stamp_ns, scan, pose, goal):
        self.stamps.append(stamp_ns)
        done = stamp_ns / 1e9 >= self.done_s
        progress = Progress(goal.id, self.state if done else State.DRIVING, 0.0, reason=self.reason if done else None)
        return Twist2D() if done else self.twist, progress


def simulated(plan=WALL):
    return PlanSimulation(plan, Pose2D(), plan_spec(BASE, LaserSpec()))


def beyond(x_m):
    return lambda sim: sim.pose.x_m >= x_m


def approaching(stamp_ns):
    """A wall that comes nearer from 1 s on."""
    moved_m = max(0.0, 1.0 * (stamp_ns / 1e9 - 1.0))
    return WALL - [moved_m, 0, moved_m, 0]


@pytest.mark.parametrize(
    ("navigator", "plan", "there_m", "outcome", "reason", "time_s"),
    [
        (Straight(done_s=3.0), WALL, 0.5, Outcome.REACHED, "", 3.0),
        (Straight(done_s=3.0), WALL, 1.5, Outcome.ELSEWHERE, "", 3.0),
        (Straight(done_s=2.0, state=State.BLOCKED, reason=Reason.ENCLOSED), WALL, 1, Outcome.BLOCKED,
         "goal enclosed", 2.0),
        (Straight(), WALL, 9.0, Outcome.CONTACT, "", 5.14),  # 1.79 m to the nose, 0.67 s of them lost in gaining speed
        (Straight(Twist2D()), approaching, 9.0, Outcome.WALKED_INTO, "", 2.8),
        (Straight(Twist2D()), WALL, 9.0, Outcome.TIMEOUT, "", 10.0),
    ],
)  # fmt: skip
def test_how_a_drive_ends(navigator, plan, there_m, outcome, reason, time_s):
    run = drive(simulated(plan), navigator, GOAL, 10.0, beyond(there_m))
    assert (run.outcome, run.reason) == (outcome, reason)
    assert run.time_s == pytest.approx(time_s, abs=0.03)
    assert (run.clearance_m == 0) == (outcome in (Outcome.CONTACT, Outcome.WALKED_INTO))


@pytest.mark.parametrize(("stops_s", "outcome"), [(2.0, Outcome.WALKED_INTO), (2.3, Outcome.CONTACT)])
def test_only_a_robot_that_has_stood_for_a_while_is_walked_into(stops_s, outcome):
    class Stops(Straight):
        def step(self, stamp_ns, scan, pose, goal):
            self.twist = Twist2D(0.05, 0.0) if stamp_ns < stops_s * 1e9 else Twist2D()
            return super().step(stamp_ns, scan, pose, goal)

    run = drive(simulated(approaching), Stops(), GOAL, 10.0, beyond(9.0))
    assert run.outcome is outcome
    assert run.time_s == pytest.approx(2.69, abs=0.03)  # it stands 0.17 s after the command


def test_where_being_there_is_enough_the_drive_ends_at_once():
    run = drive(simulated(), Straight(), GOAL, 10.0, beyond(0.5), at_once=True)
    assert run.outcome is Outcome.REACHED
    assert run.path[-1, 0] == pytest.approx(0.5, abs=0.021)
    assert run.way_m == pytest.approx(run.path[-1, 0])


def test_commands_are_given_at_20_hz():
    navigator = Straight(done_s=1.0)
    drive(simulated(), navigator, GOAL, 10.0, beyond(0.0))
    assert navigator.stamps == [50_000_000 * i for i in range(21)]


def test_the_simulated_base_is_the_configured_one():
    base = BaseConfig(max_speed_mps=0.7, laser_pose=(0.2, 0.1, 0.3), command_delay_s=0.2)
    spec = plan_spec(base, LaserSpec(), 2.0, 0.01, scan_period_ns=5)
    assert spec.base.max_speed_mps == 0.7
    assert spec.base.acceleration_mps2 == base.acceleration_mps2
    assert spec.base.yaw_acceleration_radps2 == base.yaw_acceleration_radps2
    assert spec.base.max_yaw_rate_radps == base.max_yaw_rate_radps
    assert (spec.base.left_drift_percent, spec.base.right_drift_percent, spec.base.slip_m) == (2.0, 2.0, 0.01)
    assert (spec.laser_pose, spec.command_delay_ns, spec.scan_period_ns) == (Pose2D(0.2, 0.1, 0.3), 200_000_000, 5)


def test_results_keep_the_order_of_the_jobs():
    assert every(abs, [-3, 2, -1], 2, "numbers") == [3, 2, 1]


def test_a_drive_can_be_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    run = drive(simulated(), Straight(), GOAL, 10.0, beyond(9.0))
    draw_run(tmp_path / "new" / "run.png", "a run", WALL, Hull(BASE.footprint_m), GOAL.pose, run)
    assert (tmp_path / "new" / "run.png").read_bytes().startswith(b"\x89PNG")
