# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""R5, C4 and I5, where they are the supervisor's: base that dies at speed, vision that hangs or crashes."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest

from edgefusion.config import BaseConfig, Config, PioneerConfig, SafetyConfig, VisionConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.sip_command import Command, command
from edgefusion.navigation.safety import Action, judge_health
from edgefusion.service.children import children_of
from edgefusion.service.last_stop import RobotLine, stop_robot
from edgefusion.service.supervision_actions import Send
from edgefusion.service.supervisor import TURN_S
from edgefusion.types import HealthState
from robot_faults import AHEAD, MS, SEEDS, Driven, MakeDriven, driven
from supervised import Supervised

__all__ = ["driven"]
DEFAULTS = children_of(Config(vision=VisionConfig(model="model", calibration="rig.toml")), Path("robot.toml"))


def base_dies(made: Driven) -> int:
    """In the middle of whatever it was writing. When that was."""
    died_ns = made.clock()
    packet = command(Command.VEL, 300)
    made.robot.receive(packet[: int(made.rng.integers(len(packet)))], made.link.baudrate, died_ns)
    made.line.pause(TURN_S * made.rng.random())  # until the supervisor comes by
    return died_ns


@pytest.mark.parametrize("seed", SEEDS)
def test_r5_base_dies_at_speed_the_robot_is_told_to_stop_and_stays_with_the_next_base(
    driven: MakeDriven, seed: int, tmp_path: Path
) -> None:
    made = driven(seed)
    died_ns, locks = base_dies(made), tmp_path / "locks"  # a dead base holds none
    locks.mkdir()
    assert stop_robot(RobotLine(made.link.name, 38400), None, made.clock, made.line.pause, locks) == 38400
    assert made.stopped_after_s(died_ns) <= 0.5
    made.line.pause(
        3 * made.rng.random()
    )  # by now its firmware may have stopped by itself, and would go on when spoken to
    again = Pioneer(
        Link(made.link.name, 9600, clock=made.clock, lock_folder=locks),
        PioneerConfig(),
        BaseConfig(),
        made.clock,
        made.line.pause,
    )
    again.start()
    where = made.robot.body.odometry
    for _ in range(50):
        again.poll()
    again.close()
    assert made.moved_since(died_ns) == []
    assert made.robot.body.odometry == where


@pytest.mark.parametrize("seed", SEEDS)
def test_r5_without_the_last_stop_it_would_have_driven_on(driven: MakeDriven, seed: int) -> None:
    made = driven(seed)
    died_ns = base_dies(made)
    for _ in range(20):
        made.line.pause(0.05)
        made.robot.transmit(38400, made.clock())
    assert made.clock() - died_ns >= 1000 * MS
    assert made.robot.body.twist.v_mps == pytest.approx(AHEAD.v_mps, abs=0.01)


@pytest.mark.parametrize("seed", SEEDS)
def test_c4_vision_that_hangs_is_started_again_within_5_s(seed: int) -> None:
    made, rng = Supervised(*DEFAULTS), np.random.default_rng(seed)
    made.run(1 + 20 * rng.random())
    hung_s, made.silent = made.now_s, {"vision"}
    made.run(5)
    assert next(s for s in made.starts("vision") if s > hung_s) - hung_s <= 5.0
    assert made.since(hung_s)[0] == Send("vision", signal.SIGKILL)
    assert len(made.starts("base")) == len(made.starts("bus")) == 1


@pytest.mark.parametrize("code", [-signal.SIGSEGV, -signal.SIGKILL])
@pytest.mark.parametrize("seed", SEEDS)
def test_i5_vision_that_crashes_is_back_within_5_s_until_it_did_so_five_times_in_a_minute(seed: int, code: int) -> None:
    made, rng = Supervised(*DEFAULTS), np.random.default_rng(seed)
    crashes_s: list[float] = []
    while made.health("vision").reason.find("given up") < 0 and len(crashes_s) < 20:
        made.run(30 * rng.random())
        if "vision" not in made.up:
            continue
        crashes_s.append(made.now_s)
        made.die("vision", code)
        made.run(5)
        in_a_minute = sum(crashes_s[-1] - s <= 60 for s in crashes_s)
        assert ("vision" in made.up) == (in_a_minute < 5)
    assert {made.health(name).state for name in ("bus", "base")} == {HealthState.OK}
    assert len(made.starts("base")) == len(made.starts("bus")) == 1


@pytest.mark.parametrize("code", [-signal.SIGSEGV, -signal.SIGKILL])
def test_i5_base_hears_of_vision_that_was_given_up_says_so_and_drives_on(code: int) -> None:
    made, safety = Supervised(*DEFAULTS), SafetyConfig(required=())
    for _ in range(5):
        made.run(5)
        made.die("vision", code)
    made.run(60)
    (finding,) = judge_health(made.supervision.healths(), safety)
    assert finding.reason.startswith("vision: given up after 5 failures: killed by SIG")
    assert finding.action is Action.RUN
