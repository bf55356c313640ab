# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How fast a Pioneer may go: what is configured, within what it can, and never more on the wire."""

from __future__ import annotations

import math
import struct
from typing import Optional

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.config import BaseConfig
from edgefusion.drivers.pioneer_limits import Limits, limits_of
from edgefusion.drivers.pioneer_motion import Motion
from edgefusion.drivers.sip_command import Command, command
from edgefusion.drivers.sip_config import RobotConfig
from edgefusion.types import Twist2D
from pioneer_scenes import MakeScene, packets, scene
from scripted_pioneer import ScriptedPioneer, config_body

__all__ = ["scene"]
ROBOT = RobotConfig("Pioneer", "p3dx-sh", "1", "x", 360, 1000, 300, 2000)
SIGNS = {0x3B: 1, 0x1B: -1}


def integer(body: bytes) -> int:
    return SIGNS[body[1]] * int.from_bytes(body[2:], "little")


def test_limits_are_set_within_what_the_robot_can(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.config = config_body(top_speed_mmps=400)
    made = scene(robot).started()
    assert made.told(Command.SETV) == [400]
    assert made.told(Command.SETRV) == [60]
    assert made.told(Command.SETA) == [300, -300]
    assert made.told(Command.SETRA) == [100, -100]
    for sign in (1, -1):
        made.driver.drive(Twist2D(sign * 0.5, sign * math.radians(90)))
        assert (made.told(Command.VEL)[-1], made.told(Command.RVEL)[-1]) == (sign * 400, sign * 60)


def test_tops_of_a_robot_count_where_they_are_lower() -> None:
    base = BaseConfig(max_speed_mps=2.0, max_yaw_rate_radps=10.0, acceleration_mps2=3.0, yaw_acceleration_radps2=9.0)
    limits = limits_of(base, ROBOT)
    assert limits == Limits(1.0, math.radians(360), 2.0, math.radians(300))


@pytest.mark.parametrize("parameters", [None, RobotConfig("Pioneer", "p3dx-sh", "1", "x", 360, 1000, 0, 0)])
def test_a_robot_that_does_not_say_its_tops_has_the_configured_ones(parameters: Optional[RobotConfig]) -> None:
    base = BaseConfig()
    limits = limits_of(base, parameters)
    assert limits.acceleration_mps2 == base.acceleration_mps2
    assert limits.yaw_acceleration_radps2 == base.yaw_acceleration_radps2


def test_no_acceleration_is_none_at_all() -> None:
    told = Limits(0.5, 1.0, 1e-4, 1e-4).packets()
    for number in (Command.SETA, Command.SETRA):
        assert command(number, 1) in told
        assert command(number, -1) in told


@given(
    wheels=st.booleans(),
    limits=st.tuples(st.floats(0.01, 10), st.floats(0.01, 100)),
    twist=st.tuples(st.floats(-100, 100), st.floats(-100, 100)),
)
def test_whatever_is_commanded_the_wire_carries_no_more_than_the_limits(
    wheels: bool, limits: tuple[float, float], twist: tuple[float, float]
) -> None:
    told = packets(b"".join(Motion(wheels, *limits).drive(0, Twist2D(*twist))))
    if wheels:
        steps = struct.unpack("bb", struct.pack(">h", integer(told[0])))
        assert all(-127 <= each <= 127 for each in steps)
        fastest_mmps = limits[0] * 1e3 + limits[1] / 0.0056
        assert max(map(abs, steps)) * 20 <= fastest_mmps + 11
        return
    assert abs(integer(told[0])) <= limits[0] * 1e3 + 0.5
    assert abs(integer(told[1])) <= math.degrees(limits[1]) + 0.5
