# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""However it ends, the Pioneer's driver has told the robot to stop, and moves none that it was not told to."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from edgefusion.drivers.link import LinkError, LinkLostError, LinkSilentError
from edgefusion.drivers.pioneer_line import RobotError
from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import frame
from edgefusion.errors import RefusedError
from edgefusion.types import Health, HealthState, Twist2D
from pioneer_scenes import MakeScene, last_words, scene
from scripted_pioneer import ScriptedPioneer, config_body

__all__ = ["scene"]
MOVING = (Command.VEL, Command.RVEL, Command.VEL2, Command.HEAD, Command.DHEAD)
S = 1_000_000_000


def test_whoever_closes_leaves_a_robot_that_was_told_to_stop(scene: MakeScene) -> None:
    made = scene().started()
    made.run(1.0, Twist2D(0.3))
    made.driver.close()
    assert last_words(made) == [Command.STOP, Command.VEL, Command.RVEL, Command.CLOSE]
    made.driver.start()
    assert made.run(0.5)[-1].motors_enabled
    made.driver.close()
    assert last_words(made) == [Command.STOP, Command.VEL, Command.RVEL, Command.ENABLE, Command.CLOSE]
    assert made.driver.health.state is HealthState.STARTING


@pytest.mark.parametrize("error", [RuntimeError("a defect"), KeyboardInterrupt(), SystemExit(1)])
def test_whatever_goes_wrong_the_last_word_is_a_stop(
    scene: MakeScene, error: BaseException, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = scene().started()
    made.driver.drive(Twist2D(0.3))

    def fail() -> list[object]:
        raise error

    monkeypatch.setattr(made.driver.line, "receive", fail)
    with pytest.raises(type(error)):
        made.driver.poll()
    assert last_words(made) == [Command.STOP, Command.VEL, Command.RVEL]
    assert made.driver.health.state is HealthState.FAILED
    with pytest.raises(type(error)):
        made.driver.start()
    assert last_words(made) == [Command.STOP, Command.VEL, Command.RVEL]


def test_leaving_the_with_block_stops_the_robot(scene: MakeScene) -> None:
    made = scene()
    with pytest.raises(RuntimeError), made.driver as driver:
        driver.start()
        driver.drive(Twist2D(0.3))
        raise RuntimeError("the owner's defect")
    assert Command.STOP in last_words(made)
    assert not made.link.is_open


def test_nothing_moves_after_a_reconnection_until_a_new_command(scene: MakeScene) -> None:
    made = scene().started()
    made.run(1.0, Twist2D(0.3))
    made.line.plugged = False
    with pytest.raises(LinkLostError):
        made.run(1.0, Twist2D(0.3))
    with pytest.raises(RobotError, match=r"expected start\(\) before drive\(\)"):
        made.driver.drive(Twist2D(0.3))
    made.line.plugged = True
    before = len(made.robot.told)
    made.driver.start()
    made.run(3.0)
    assert all(not argument for told, argument in made.robot.told[before:] if told in MOVING)
    made.driver.drive(Twist2D(0.3))
    assert made.told(Command.VEL)[-1] == 300


def test_a_silent_robot_is_lost(scene: MakeScene) -> None:
    made = scene().started()
    made.robot.mute = True
    began_ns = made.clock()
    with pytest.raises(LinkSilentError, match="nothing came"):
        made.run(2.0)
    assert made.clock() - began_ns <= 0.3 * S


def test_a_slow_robot_may_be_silent_for_longer(scene: MakeScene) -> None:
    robot = ScriptedPioneer()
    robot.config = config_body(cycle_ms=200)
    made = scene(robot).started()
    assert made.driver.info is not None
    assert made.driver.info.silence_s == pytest.approx(0.5)


def test_a_robot_that_babbles_is_lost(scene: MakeScene) -> None:
    made = scene().started()
    made.robot.mute = True
    made.robot.say = [b""]
    with pytest.raises(RobotError, match="nothing that makes sense"):
        for _ in range(1000):
            made.robot.say = [b"\xfa\x00"]
            made.driver.poll()


def test_a_robot_that_began_anew_is_told_by_its_reply_to_a_pulse(scene: MakeScene) -> None:
    made = scene().started()
    made.robot.say = [frame(b"\0")]
    with pytest.raises(RobotError, match="the robot began anew"):
        made.run(0.1)


@given(noise=st.lists(st.binary(max_size=60), max_size=10), cut=st.integers(0, 200))
@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_whatever_bytes_come_it_is_driven_or_lost_and_never_anything_else(
    scene: MakeScene, noise: list[bytes], cut: int
) -> None:
    """Noise between the robot's packets, in the handshake and in the session; some of it well framed."""
    robot = ScriptedPioneer()
    robot.say = [frame(each) if index % 2 and each else each for index, each in enumerate(noise)]
    made = scene(robot)
    try:
        made.driver.start()
        robot.say = [each[cut % (len(each) + 1) :] for each in noise]
        made.run(0.5, Twist2D(0.3))
        assert made.driver.info is not None
    except (LinkError, RefusedError) as error:
        assert made.driver.info is None
        assert made.driver.health == Health("robot", HealthState.FAILED, " ".join(str(error).split()))
    made.driver.close()
    assert Command.STOP in last_words(made)
