# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the Pioneer's driver tells a scripted robot, and what the robot's states are then."""

from __future__ import annotations

import math

import pytest

from edgefusion.drivers.link import LinkError
from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import frame
from edgefusion.errors import RefusedError
from edgefusion.types import HealthState, Pose2D, Twist2D
from pioneer_scenes import MakeScene, scene
from sip_traces import sip

__all__ = ["scene"]
MOVING = (Command.VEL, Command.RVEL, Command.VEL2, Command.HEAD, Command.DHEAD)
S = 1_000_000_000


@pytest.mark.parametrize(
    ("twist", "told"), [((0.25, 0.0), (250, 0)), ((-0.1, 0.0), (-100, 0)), ((0.0, math.radians(-10)), (0, -10))]
)
def test_a_velocity_arrives_as_it_is_meant(scene: MakeScene, twist: tuple, told: tuple) -> None:
    made = scene().started()
    made.driver.drive(Twist2D(*twist))
    assert (made.robot.v_mmps, made.robot.w_dps) == told


def test_a_velocity_of_the_wheels_arrives_as_steps_of_20_mm_per_s(scene: MakeScene) -> None:
    made = scene(velocities="wheels").started()
    made.driver.drive(Twist2D(0.2, 0.0))
    made.driver.drive(Twist2D(0.0, -0.224))
    assert made.told(Command.VEL2) == [0x0A0A, 0x02FE]
    assert made.told(Command.VEL) == []


def test_a_velocity_is_refreshed_and_is_zero_once_it_is_old(scene: MakeScene) -> None:
    made = scene().started()
    made.driver.drive(Twist2D(0.3))
    given_ns = made.clock()
    while made.robot.v_mmps:
        made.driver.poll()
    assert 300 <= (made.line.written[-1][0] - given_ns) / 1e6 <= 320
    made.run(3.0)
    velocities = made.told(Command.VEL)
    assert velocities.count(300) >= 3
    assert velocities[-1] == 0
    assert velocities.count(0) >= 5  # a robot that missed one would go on for ever


@pytest.mark.parametrize(("age_ms", "drives_for_ms"), [(0, 300), (200, 100), (400, 0), (-5000, 300)])
def test_the_age_of_a_velocity_counts_from_when_it_was_worked_out(scene: MakeScene, age_ms, drives_for_ms) -> None:
    made = scene().started()
    handed_ns = made.clock()
    made.driver.drive(Twist2D(0.3), handed_ns - age_ms * S // 1000)
    while made.robot.v_mmps:
        made.driver.poll()
    assert drives_for_ms <= (made.clock() - handed_ns) / 1e6 <= drives_for_ms + 40


def test_an_idle_robot_is_pulsed_at_least_once_a_second(scene: MakeScene) -> None:
    made = scene().started()
    made.run(2.0)
    before_ns = made.clock()
    made.run(10.0)
    times = [before_ns, *(ns for ns, data in made.line.written if ns > before_ns and data), made.clock()]
    assert max(after - before for before, after in zip(times, times[1:])) <= 0.6 * S
    assert made.robot.told[-1][0] == Command.PULSE


def test_a_turn_by_the_robots_own_control_is_not_interrupted(scene: MakeScene) -> None:
    made = scene().started()
    made.driver.drive(Twist2D(0.3))
    made.driver.turn_by(math.radians(-90))
    before = len(made.robot.told)
    made.run(3.0)
    assert made.told(Command.DHEAD) == [-90]
    assert {number for number, _ in made.robot.told[before:]} == {Command.PULSE}
    assert made.driver.health.state is HealthState.OK


@pytest.mark.parametrize("angle", [math.nan, math.inf, -math.inf])
def test_a_turn_that_is_no_number_is_refused_and_the_robot_stays_as_it_is(scene: MakeScene, angle: float) -> None:
    made = scene().started()
    told = len(made.robot.told)
    for turn in (made.driver.turn_by, made.driver.turn_to):
        with pytest.raises(RefusedError, match=f"angle: expected a finite number, got {angle}"):
            turn(angle)
    assert len(made.robot.told) == told
    assert made.driver.info is not None


def test_a_heading_is_the_robots_own_also_after_its_counts_began_anew(scene: MakeScene) -> None:
    made = scene().started()
    made.run(3.0, Twist2D(0.0, math.radians(30)))
    made.driver.stop()
    turned = made.run(0.5)[-1].odometry.theta
    made.robot.reset()
    with pytest.raises(LinkError):
        made.run(1.0)
    made.driver.start()
    made.driver.turn_to(turned + math.radians(45))
    assert made.told(Command.HEAD) == [45]


@pytest.mark.parametrize(("heading", "told"), [(-90, 270), (359.8, 0), (-0.2, 0), (180, 180), (725, 5)])
def test_a_heading_goes_as_whole_degrees_below_360(scene: MakeScene, heading: float, told: int) -> None:
    made = scene().started()
    made.driver.turn_to(math.radians(heading))
    assert made.told(Command.HEAD) == [told]


@pytest.mark.parametrize("on", [True, False])
def test_motors_that_are_switched_move_nothing_until_a_new_command(scene: MakeScene, on: bool) -> None:
    made = scene().started()
    made.driver.drive(Twist2D(0.3))
    before = len(made.robot.told)
    made.driver.enable_motors(on)
    assert made.run(0.5)[-1].motors_enabled is on
    assert (Command.ENABLE, int(on)) in made.robot.told[before:]
    assert all(argument == 0 for told, argument in made.robot.told[before:] if told in MOVING)
    assert made.robot.v_mmps == 0


def test_reports_that_were_held_up_and_came_at_once_follow_each_other(scene: MakeScene) -> None:
    made = scene().started()
    made.run(0.5)
    made.robot.say = [sip()] * 3
    stamps_ns = [state.stamp_ns for state in made.run(0.5)]
    assert len(stamps_ns) >= 7
    assert all(before < after for before, after in zip(stamps_ns, stamps_ns[1:]))


def test_stops_are_said_and_what_was_commanded_is_forgotten(scene: MakeScene) -> None:
    made = scene().started()
    for stop, number in ((made.driver.stop, Command.STOP), (made.driver.e_stop, Command.E_STOP)):
        made.driver.drive(Twist2D(0.3))
        before = len(made.robot.told)
        stop()
        made.run(1.0)
        assert made.robot.told[before][0] == number
        assert all(argument == 0 for told, argument in made.robot.told[before:] if told in MOVING)


def test_sonar_and_outputs_are_switched(scene: MakeScene) -> None:
    made = scene(sonar=False).started()
    made.driver.set_sonar(True)
    made.driver.set_digital_outputs(0x0F, 0x05)
    assert made.told(Command.SONAR) == [0, 1]
    assert made.told(Command.DIGOUT) == [0x0F05]
    with pytest.raises(RefusedError, match="mask: expected 0 to 255, got 256"):
        made.driver.set_digital_outputs(256, 0)


def test_the_pose_begins_anew_when_that_is_asked_for(scene: MakeScene) -> None:
    made = scene().started()
    made.run(2.0, Twist2D(0.3))
    with pytest.raises(RefusedError, match="expected a robot that stands"):
        made.driver.reset_odometry()
    made.driver.stop()
    assert made.run(0.5)[-1].odometry.x_m == pytest.approx(0.58, abs=0.05)
    made.driver.reset_odometry()
    assert [state.odometry for state in made.run(1.0)] == [Pose2D()] * 10
    assert made.run(1.0, Twist2D(0.3))[-1].odometry.x_m == pytest.approx(0.28, abs=0.04)


def test_the_pose_begins_anew_also_where_the_session_ends_at_once(scene: MakeScene) -> None:
    made = scene().started()
    made.run(1.0, Twist2D(0.3))
    made.driver.stop()
    made.run(0.5)
    made.driver.reset_odometry()
    made.driver.close()
    made.driver.start()
    assert made.run(0.3)[-1].odometry == Pose2D()


def test_unknown_packets_are_skipped_and_counted(scene: MakeScene) -> None:
    made = scene().started()
    made.robot.say = [frame(b"\x90" + bytes(8)), frame(b"\xf0\x00"), frame(b"\xb0abc")]
    assert made.run(1.0)
    assert made.driver.line.reader.unknown_packets == 3


def test_a_state_is_stamped_when_it_began_to_leave_the_robot(scene: MakeScene) -> None:
    made = scene(faster_baudrate=None).started()
    made.run(0.5)
    while not (states := made.driver.poll()):
        pass
    line_ns = len(sip()) * 10 * S // 9600
    assert made.clock() - states[-1].stamp_ns == line_ns
