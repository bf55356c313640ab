# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is left of a wished velocity: all of it in the open, less before a wall, another arc, or nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from edgefusion.navigation.steering import Steering
from edgefusion.navigation.surroundings import Surroundings
from edgefusion.types import Pose2D, Twist2D
from navigation_scenes import see, wall
from navigator_drives import BASE, NAVIGATION

STANDS = (0.0, 0.0, 0.0, 0.0, 0.0)
FAST = (0.0, 0.0, 0.0, 0.5, 0.0)
HOLD_S = 0.1
WISHES = [Twist2D(0.5, 0.0), Twist2D(0.3, math.radians(20)), Twist2D(0.2, -math.radians(30)), Twist2D(0.0, 1.0)]


def among(points, motion=STANDS, rear=(), seen_m=3.0, hold_s=HOLD_S):
    """Where the ground is seen for so far, and these points are."""
    around = Surroundings(NAVIGATION, BASE)
    around.stand(0, Pose2D(*motion[:3]), Pose2D())
    if seen_m:
        see(around.map, radius_m=seen_m)
    standing = np.concatenate([np.asarray(points, float).reshape(-1, 2), np.asarray(rear, float).reshape(-1, 2)])
    around.look(0, motion, Pose2D(*motion[:3]), standing)
    return Steering(around, NAVIGATION.margin_m, motion, hold_s)


def ahead(x_m):
    return wall((x_m, -2.0), (x_m, 2.0))


@pytest.mark.parametrize("wish", WISHES)
def test_in_the_open_the_wish_is_permitted_as_the_wire_carries_it(wish):
    given = among([]).permitted(wish)
    assert given.v_mps == pytest.approx(wish.v_mps, abs=0.001)
    assert given.w_radps == pytest.approx(wish.w_radps, abs=math.radians(1))


def test_a_command_for_standing_is_always_permitted():
    assert among(ahead(0.22)).permitted(Twist2D()) == Twist2D()
    assert among(ahead(0.22)).along(Twist2D()) == Twist2D()


def test_it_is_slower_the_nearer_the_wall_is():
    """At half a metre a second 0.42 m are needed to brake."""
    speeds = [among(ahead(0.21 + gap_m), FAST).permitted(Twist2D(0.5, 0.0)).v_mps for gap_m in (0.43, 0.46, 0.48, 0.6)]
    assert speeds == sorted(speeds)
    assert speeds[0] == 0
    assert 0 < speeds[2] <= 0.5
    assert speeds[3] == 0.5


def test_the_longer_a_command_may_last_the_slower_it_is():
    gap = ahead(0.21 + 0.55)
    speeds = [among(gap, FAST, hold_s=hold_s).permitted(Twist2D(0.5, 0.0)).v_mps for hold_s in (0.1, 0.3, 0.8)]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] == 0.5
    assert speeds[2] < 0.4


def test_close_before_the_nose_there_is_no_going_on():
    near = [(0.22, y) for y in np.linspace(-0.1, 0.1, 9)]
    assert among(near).permitted(Twist2D(0.5, 0.0)) == Twist2D()
    assert among(near).along(Twist2D(0.15, 0.0)) == Twist2D()


def test_a_turn_whose_tail_would_hit_is_not_permitted_the_other_is():
    """Behind the tail's right corner: to turn left swings the tail to the right."""
    rear = [(-0.30, -0.23)]
    assert among([], rear=rear).permitted(Twist2D(0.0, 1.0)) == Twist2D()
    assert among([], rear=rear).permitted(Twist2D(0.0, -1.0)).w_radps == pytest.approx(-1.0, abs=math.radians(1))


def test_where_the_arc_is_not_free_a_straighter_one_may_be():
    given = among(wall((-0.5, 0.235), (2.0, 0.235)), (0.0, 0.0, 0.0, 0.2, 0.0)).permitted(
        Twist2D(0.2, math.radians(40))
    )
    assert given == Twist2D(0.2, 0.0)


def test_a_manoeuvre_stays_on_its_own_arc_and_may_come_closer():
    wish, moving = Twist2D(0.15, math.radians(10)), (0.0, 0.0, 0.0, 0.1, 0.0)
    before = ahead(0.21 + 0.036)
    assert among(before, moving).permitted(wish) == Twist2D()
    assert among(before, moving).along(wish) != Twist2D()
    slower = [among(ahead(0.21 + gap_m), moving).along(wish) for gap_m in np.arange(0.03, 0.06, 0.002)]
    driven = {twist for twist in slower if twist != Twist2D()}
    assert len(driven) > 1
    for twist in driven:
        assert twist.w_radps / twist.v_mps == pytest.approx(wish.w_radps / wish.v_mps, rel=0.01)


def test_nobody_drives_over_ground_that_was_not_seen():
    unseen = among([], seen_m=0.0)
    for wish in (Twist2D(0.5, 0.0), Twist2D(-0.15, 0.0)):
        assert unseen.permitted(wish) == Twist2D()
        assert unseen.along(wish) == Twist2D()
    assert unseen.permitted(Twist2D(0.0, 0.5)).w_radps > 0  # to turn, it need not


@pytest.mark.parametrize("wish", WISHES)
def test_what_is_permitted_is_never_more_than_the_wish(wish):
    for x_m in np.arange(0.25, 1.0, 0.05):
        given = among(ahead(x_m), FAST).permitted(wish)
        assert 0 <= given.v_mps <= wish.v_mps
        assert abs(given.w_radps) <= abs(wish.w_radps)
        assert given.w_radps * wish.w_radps >= 0
