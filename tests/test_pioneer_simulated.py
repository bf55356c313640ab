# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The Pioneer's driver against the simulated firmware, of either board and with any parameters."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from edgefusion.drivers.sip_command import Command
from edgefusion.sim.sip_robot_character import H8, SH, Character
from edgefusion.types import HealthState, Pose2D, Twist2D
from pioneer_scenes import MakeScene, SimulatedPioneer, packets, scene
from sip_traces import read_trace

__all__ = ["scene"]
CHARACTERS = [
    replace(board, config_packet=config, counter_bits=bits)
    for board, bits in ((H8, 15), (SH, 15), (SH, 16))
    for config in ("right", "wrong", "missing")
]


def name_of(character: Character) -> str:
    return f"{character.subtype}-{character.config_packet}-{character.counter_bits}"


@pytest.mark.parametrize("character", CHARACTERS, ids=name_of)
def test_it_is_driven_where_it_is_told_and_knows_where_it_is(scene: MakeScene, character: Character) -> None:
    made = scene(SimulatedPioneer(character)).started()
    assert made.driver.health.state is HealthState.OK
    for twist in (Twist2D(0.4), Twist2D(0.0, math.radians(-50)), Twist2D(-0.3, 0.4)):
        made.run(2.0, twist)
    made.driver.stop()
    pose, truth = made.run(2.0)[-1].odometry, made.robot.body.odometry
    assert math.hypot(truth.x_m, truth.y_m) > 0.3
    assert math.dist((pose.x_m, pose.y_m), (truth.x_m, truth.y_m)) < 0.005
    assert math.remainder(pose.theta - truth.theta, 2 * math.pi) == pytest.approx(0.0, abs=0.003)
    assert made.driver.implausible_statuses == 0
    assert made.driver.health.state is HealthState.OK


@pytest.mark.parametrize("character", [H8, SH], ids=name_of)
def test_only_a_robot_that_says_that_it_comes_back_is_made_faster(scene: MakeScene, character: Character) -> None:
    made = scene(SimulatedPioneer(character)).started()
    assert made.link.baudrate == made.robot.firmware.line.baudrate == 38400
    made.driver.close()
    assert made.robot.firmware.line.baudrate == 9600
    made = scene(SimulatedPioneer(replace(character, autobaud=0))).started()
    assert made.robot.firmware.line.baudrate == 9600


def test_it_turns_to_headings_by_itself(scene: MakeScene) -> None:
    made = scene(SimulatedPioneer()).started()
    made.driver.turn_to(math.radians(120))
    assert made.run(6.0)[-1].odometry.theta == pytest.approx(math.radians(120), abs=0.02)
    made.driver.turn_by(math.radians(-90))
    assert made.run(6.0)[-1].odometry.theta == pytest.approx(math.radians(30), abs=0.04)
    assert made.driver.health.state is HealthState.OK


def test_its_odometry_begins_anew(scene: MakeScene) -> None:
    made = scene(SimulatedPioneer()).started()
    made.run(2.0, Twist2D(0.3, 0.3))
    made.driver.stop()
    made.run(2.0)
    made.driver.reset_odometry()
    assert {state.odometry for state in made.run(1.0)} == {Pose2D()}


def test_its_packets_are_of_the_kinds_and_in_the_order_of_a_recorded_connection(scene: MakeScene, shared_data) -> None:
    """Of both sides; kinds that one of the two hosts has no use for are left out."""
    trace = shared_data / "sip/sip_session1.hex"
    hosts, robots = ([packet[3] for packet, holds in read_trace(trace, side) if holds] for side in "CR")
    made = scene(SimulatedPioneer(), faster_baudrate=None)
    made.driver.start()
    made.run(2.0)
    made.run(1.0, Twist2D(0.25))
    made.driver.stop()
    made.run(2.0)
    made.driver.close()
    ours = [told.number for _, told in made.robot.firmware.heard]
    common = {0, 1, 2, 4, 5, 6, 10, 11, 18, 21, 23}
    assert list(dict.fromkeys(n for n in ours if n in common)) == list(dict.fromkeys(n for n in hosts if n in common))
    assert ours[-2:] == [Command.ENABLE, Command.CLOSE] == hosts[-2:]
    theirs = [body[0] if body[0] != 0x33 else 0x32 for body in packets(bytes(made.robot.said))]
    assert list(dict.fromkeys(theirs)) == list(dict.fromkeys(robots))
