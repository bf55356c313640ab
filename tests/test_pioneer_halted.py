# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the Pioneer's driver makes of a robot to which it did not listen for a while: its process was halted."""

from __future__ import annotations

import pytest

from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.drivers.sip_command import Command
from edgefusion.types import HealthState, Twist2D
from pioneer_scenes import MakeScene, Scene, SimulatedPioneer, packets, scene

__all__ = ["scene"]
AHEAD = Twist2D(0.4)
STEP_NS = 10_000_000
HALTS_S = pytest.mark.parametrize("halted_s", [0.35, 1.2, 1.9])


def halted(made: Scene, seconds: float) -> list[RobotState]:
    """Driving, then halted, then all that it finds. The bytes of the robot wait."""
    made.run(3.0, AHEAD)
    for _ in range(round(seconds * 1e9 / STEP_NS)):
        made.clock.advance(STEP_NS)
        assert made.link.waiting_bytes >= 0
    states: list[RobotState] = []
    healths = []
    while made.link.waiting_bytes or not states:
        states += made.driver.poll()
        healths.append(made.driver.health)
    assert {health.state for health in healths} == {HealthState.OK}, healths
    return states


@HALTS_S
def test_a_robot_is_not_lost_by_who_was_halted_and_the_first_that_it_hears_is_zero(
    scene: MakeScene, halted_s: float
) -> None:
    made = scene(SimulatedPioneer()).started()
    before = len(made.line.written)
    halted(made, halted_s)
    written = [packets(data) for _, data in made.line.written[before:]]
    first = next(said for said, (ns, _) in zip(written, made.line.written[before:]) if ns >= made.clock() - 10**8)
    assert first == [bytes([Command.VEL, 0x3B, 0, 0]), bytes([Command.RVEL, 0x3B, 0, 0])]
    assert made.driver.info is not None


@HALTS_S
def test_reports_that_were_read_late_are_stamped_when_they_were_sent(scene: MakeScene, halted_s: float) -> None:
    made = scene(SimulatedPioneer()).started()
    states = halted(made, halted_s)
    assert len(states) >= int(10 * halted_s) - 1
    now_ns = made.clock()
    for state in states:  # it drives evenly: the way that it has gone since tells how long ago it was there
        gone_m = made.robot.body.odometry.x_m - state.odometry.x_m
        late_s = gone_m / AHEAD.v_mps - (now_ns - state.stamp_ns) / 1e9
        assert abs(late_s) <= 0.02
    assert all(a.stamp_ns < b.stamp_ns for a, b in zip(states, states[1:]))
