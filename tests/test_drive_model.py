# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The model of the drive against the simulated one: where it will be when a command takes effect, and how fast."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edgefusion.config import BaseConfig
from edgefusion.navigation.drive_model import DriveModel, turned
from edgefusion.sim.robot import BaseSpec, SimBase
from edgefusion.types import Pose2D, Twist2D

CYCLE_NS, S = 50_000_000, 1_000_000_000
FINE_NS = 10_000_000
COMMANDS = st.builds(
    lambda mm, degrees: Twist2D(mm / 1000, math.radians(degrees)), st.integers(-500, 500), st.integers(-60, 60)
)


class Driven:
    """A model and the simulated base, which gets every command so much later; knows where the base was when."""

    def __init__(self, delay_ns, base=None):
        base = base or BaseConfig(command_delay_s=delay_ns / S)
        self.model, self.base = DriveModel(base), SimBase(BaseSpec())
        self.delay_ns, self.commands = delay_ns, []
        self.states = {0: (self.base.pose, self.base.twist)}

    def run_to(self, stamp_ns):
        while self.base.stamp_ns < stamp_ns:
            for due_ns, twist in self.commands:
                if due_ns == self.base.stamp_ns:
                    self.base.command(twist)
            self.base.step(FINE_NS)
            self.states[self.base.stamp_ns] = self.base.pose, self.base.twist

    def cycle(self, twist):
        now_ns, before = self.base.stamp_ns, self.base.odometry
        self.model.commanded(now_ns, twist)
        self.commands.append((now_ns + self.delay_ns, twist))
        self.run_to(now_ns + CYCLE_NS)
        self.model.moved(now_ns, now_ns + CYCLE_NS, self.base.odometry.relative_to(before))


@settings(max_examples=40)
@given(st.lists(COMMANDS, min_size=1, max_size=15), st.sampled_from([0, 50_000_000, 120_000_000, 200_000_000]))
def test_it_foretells_where_the_base_is_when_the_next_command_takes_effect(commands, delay_ns):
    driven, foretold = Driven(delay_ns), []
    for twist in commands:
        driven.cycle(twist)
        now_ns = driven.base.stamp_ns
        foretold.append((now_ns + delay_ns, driven.model.ahead(now_ns, driven.base.pose)))
    driven.run_to(foretold[-1][0])
    for stamp_ns, (x, y, theta, v, w) in foretold:
        pose, twist = driven.states[stamp_ns]
        assert math.dist((x, y), (pose.x_m, pose.y_m)) < 0.002
        assert abs(turned(theta, pose.theta)) < 0.01
        assert (v, w) == pytest.approx((twist.v_mps, twist.w_radps), abs=0.02)


def test_commands_on_their_way_count_and_those_behind_them_do_not_yet():
    """0.2 s late, from standing: after 0.2 s of a command for 0.5 m/s the base has not moved, 0.2 s later 6 mm."""
    driven = Driven(200_000_000)
    for _ in range(4):
        driven.cycle(Twist2D(0.5, 0.0))
    assert driven.base.pose == Pose2D()
    x, y, theta, v, w = driven.model.ahead(driven.base.stamp_ns, driven.base.pose)
    assert (x, y, theta, v, w) == pytest.approx((0.5 * 0.3 * 0.2**2, 0.0, 0.0, 0.06, 0.0), abs=1e-6)


def test_it_starts_from_the_pose_that_it_is_given():
    driven = Driven(100_000_000)
    for _ in range(30):
        driven.cycle(Twist2D(0.3, 0.0))
    x, y, *_ = driven.model.ahead(driven.base.stamp_ns, Pose2D(5.0, 1.0, math.pi / 2))
    assert (x, y) == pytest.approx((5.0, 1.0 + 0.03), abs=1e-3)


def test_a_base_that_does_not_follow_is_believed_not_the_command():
    model = DriveModel(BaseConfig())
    for tick in range(40):
        model.commanded(tick * CYCLE_NS, Twist2D(0.5, 0.0))
        model.moved(tick * CYCLE_NS, (tick + 1) * CYCLE_NS, Pose2D())
    assert abs(model.twist.v_mps) < 0.16


def test_a_base_that_others_push_is_not_taken_to_stand():
    model = DriveModel(BaseConfig())
    assert model.stands
    for tick in range(20):
        model.commanded(tick * CYCLE_NS, Twist2D())
        model.moved(tick * CYCLE_NS, (tick + 1) * CYCLE_NS, Pose2D(0.3 * 0.05, 0.0, 0.0))
    assert not model.stands
    assert model.twist.v_mps == pytest.approx(0.3, abs=0.16)


def test_a_base_that_rolls_slowly_against_its_command_does_not_stand():
    model = DriveModel(BaseConfig())
    for tick in range(20):
        model.commanded(tick * CYCLE_NS, Twist2D())
        model.moved(tick * CYCLE_NS, (tick + 1) * CYCLE_NS, Pose2D(0.08 * 0.05, 0.0, 0.0))
    assert not model.stands


def test_it_stands_once_the_base_does():
    driven, stands, speeds = Driven(50_000_000), [], []
    for tick in range(80):
        driven.cycle(Twist2D(0.4, 0.3) if tick < 30 else Twist2D())
        stands.append(driven.model.stands)
        speeds.append(driven.base.twist.v_mps)
    assert not any(stand and speed > 0.04 for stand, speed in zip(stands, speeds))
    assert stands[-1]


def test_what_was_really_sent_takes_the_place_of_the_last_command():
    models = [DriveModel(BaseConfig()) for _ in range(2)]
    for model in models:
        model.commanded(0, Twist2D(0.5, 0.0))
    models[1].sent(Twist2D())
    for model in models:
        model.moved(0, CYCLE_NS, Pose2D())
        model.commanded(CYCLE_NS, Twist2D())
    ahead = [model.ahead(CYCLE_NS, Pose2D())[3] for model in models]
    assert ahead[0] == pytest.approx(0.3 * 0.05)
    assert ahead[1] == 0


def test_odometry_that_comes_every_other_cycle_does_not_confuse_it():
    """A P3-DX reports every 100 ms."""
    driven, kept = Driven(50_000_000), Pose2D()
    model, errors = driven.model, []
    for tick in range(60):
        now_ns = driven.base.stamp_ns
        model.commanded(now_ns, Twist2D(0.4, 0.0))
        driven.commands.append((now_ns + driven.delay_ns, Twist2D(0.4, 0.0)))
        driven.run_to(now_ns + CYCLE_NS)
        new = driven.base.odometry if tick % 2 else kept
        model.moved(now_ns, now_ns + CYCLE_NS, new.relative_to(kept))
        kept = new
        errors.append(model.twist.v_mps - driven.base.twist.v_mps)
    assert np.abs(errors).max() < 0.1


@pytest.mark.parametrize(
    ("a", "b", "turn"), [(1.0, 0.5, 0.5), (0.5, 1.0, -0.5), (3.0, -3.0, 6.0 - 2 * math.pi), (7.0, 0.0, 7 - 2 * math.pi)]
)
def test_the_turn_between_two_directions_is_the_short_one(a, b, turn):
    assert turned(a, b) == pytest.approx(turn)
