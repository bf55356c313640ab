# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The Pioneer's driver finds a scripted robot in any state that a crash left, and brings it to where it is driven."""

from __future__ import annotations

import pytest

from edgefusion.drivers.pioneer_line import RobotError
from edgefusion.drivers.sip_command import Command
from edgefusion.errors import RefusedError
from edgefusion.types import HealthState, Twist2D
from pioneer_scenes import MakeScene, packets, scene
from scripted_pioneer import ScriptedPioneer, config_body
from sip_traces import read_trace

__all__ = ["scene"]
SPEEDS = (9600, 19200, 38400, 57600, 115200)
S = 1_000_000_000


@pytest.mark.parametrize("left_at", SPEEDS)
def test_a_robot_is_found_at_any_speed_and_brought_to_the_faster_one(scene: MakeScene, left_at: int) -> None:
    made = scene(ScriptedPioneer(left_at)).started()
    assert made.robot.baud == made.link.baudrate == max(left_at, 38400)
    assert made.driver.health.state is HealthState.OK
    assert made.driver.info is not None
    assert made.driver.info.identity.subtype == "p3dx-sh"
    assert made.run(1.0)


@pytest.mark.parametrize("left_at", SPEEDS)
def test_a_session_that_a_crash_left_driving_is_stopped_before_all_else(scene: MakeScene, left_at: int) -> None:
    robot = ScriptedPioneer(left_at)
    robot.stage, robot.motors, robot.v_mmps = 4, True, 300
    made = scene(robot).started()
    assert robot.told[0][0] == Command.STOP
    assert all(packets(data)[0] == bytes([Command.STOP]) for _, data in made.line.written[:1])
    assert robot.v_mmps == 0
    assert Command.CLOSE in robot.kinds()


def test_a_robot_whose_handshake_ended_but_that_nobody_opened_is_found(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.stage = 3
    scene(robot).started()
    assert robot.stage == 4


def test_a_robot_that_is_out_of_step_begins_anew(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.out_of_step = True
    scene(robot).started()
    assert robot.stage == 4


def test_a_robot_that_is_only_just_switched_on_is_found_in_the_same_search(scene: MakeScene) -> None:
    made = scene()
    made.robot.off = True
    pause = made.line.clock.advance
    began_ns = made.clock()

    def later(ns: int) -> int:
        made.robot.off = made.clock() < began_ns + 2 * S
        return pause(ns)

    made.line.clock.advance = later  # type: ignore[method-assign]
    made.driver.start()
    assert made.clock() - began_ns < 5 * S


def test_no_robot_at_any_speed_is_said(scene: MakeScene) -> None:
    made = scene()
    made.robot.off = True
    with pytest.raises(RobotError, match="got no answer at any of 9600, 38400, 19200, 115200, 57600 baud"):
        made.driver.start()
    assert made.driver.health.state is HealthState.FAILED
    assert "no answer" in made.driver.health.reason


def test_the_first_word_in_a_session_is_to_stop(scene: MakeScene) -> None:
    made = scene().started()
    numbers = [number for number, _ in made.robot.told]
    opened = numbers.index(Command.OPEN, numbers.index(Command.CLOSE) + 1)  # CLOSE is the number of SYNC2
    assert numbers[opened + 1] == Command.STOP


@pytest.mark.parametrize("checksum_holds", [True, False])
def test_the_parameters_are_read_whatever_their_checksum(scene: MakeScene, checksum_holds: bool) -> None:
    robot = ScriptedPioneer()
    robot.config_checksum = checksum_holds
    made = scene(robot).started()
    assert made.driver.info is not None
    assert made.driver.info.parameters is not None
    assert made.driver.info.parameters.autobaud == 2
    assert made.told(Command.CONFIG) == [1]


def test_a_robot_without_parameters_is_driven_at_the_speed_it_was_found_at(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.config = b""
    made = scene(robot).started()
    assert made.driver.info is not None
    assert made.driver.info.parameters is None
    assert robot.baud == 9600
    assert made.run(0.5, Twist2D(0.1))


def test_a_robot_that_would_stay_at_another_speed_is_left_at_its_own(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.config = config_body(autobaud=0)
    made = scene(robot).started()
    assert robot.baud == 9600
    assert made.told(Command.HOSTBAUD) == []


def test_motors_are_enabled_and_a_state_says_so(scene: MakeScene) -> None:
    made = scene().started()
    assert made.told(Command.ENABLE) == [1]
    assert made.run(0.3)[-1].motors_enabled


def test_motors_that_stay_off_are_the_healths_words(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.deaf_to_enable = robot.e_stop = True
    made = scene(robot).started()
    assert made.driver.health.state is HealthState.FAILED
    assert made.driver.health.reason == "the emergency stop is pressed; the motors are off"
    assert made.run(0.3)[-1].e_stop_pressed


def test_motors_are_left_to_the_button_where_the_configuration_says_so(scene: MakeScene) -> None:
    made = scene(enable_motors=False).started()
    assert made.told(Command.ENABLE) == []
    assert made.driver.health.reason == "the motors are off"


def test_a_subtype_whose_counts_nobody_knows_is_refused_unless_configured(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.identity = b"\2x\0Pioneer\0p9\0"
    made = scene(robot)
    with pytest.raises(RefusedError, match="expected a subtype of p3dx or p3dx-sh, or distance_factor_mm"):
        made.driver.start()
    made.driver.close()
    scene(robot, distance_factor_mm=0.58).started()


def test_what_is_told_follows_the_order_of_a_recorded_connection(scene: MakeScene, shared_data) -> None:
    """Of the kinds that both know; what the recorded host left to its program, ours must not say before."""
    recorded = [packet[3] for packet, holds in read_trace(shared_data / "sip/sip_session1.hex", "C") if holds]
    made = scene(faster_baudrate=None)
    made.driver.start()
    made.run(2.0)
    made.run(1.0, Twist2D(0.25))
    made.driver.stop()
    made.run(1.0)
    made.driver.close()
    ours = [number for number, _ in made.robot.told]
    common = (0, 1, 2, Command.CONFIG, Command.SETV, Command.SETA, Command.SETRV, Command.SETRA, Command.ENABLE)

    def order(numbers: list[int]) -> list[int]:
        """Where each kind appears for the first time, and the end."""
        known = [number for number in numbers if number in (*common, Command.VEL, Command.RVEL)]
        return [*dict.fromkeys(known), *known[-2:]]

    assert order(ours) == order(recorded)
