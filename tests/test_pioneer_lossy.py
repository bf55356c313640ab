# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A Pioneer that misses, cuts short or babbles some of what is said is brought to where it is driven all the same."""

from __future__ import annotations

from pathlib import Path
from typing import Optional

import pytest

from edgefusion.config import BaseConfig, PioneerConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_line import RobotError
from edgefusion.drivers.sip_command import Command
from edgefusion.types import HealthState
from pioneer_scenes import MakeScene, scene
from scripted_pioneer import IDENTITY, ScriptedPioneer

__all__ = ["scene"]
S = 1_000_000_000


class Forgetful(ScriptedPioneer):
    """misses: of the packets that come, counted from 0; deaf_to: commands that it does not follow, each so often."""

    def __init__(self, misses: tuple[int, ...] = (), deaf_to: Optional[dict[int, int]] = None) -> None:
        super().__init__()
        self._misses, self._deaf_to, self._packets = misses, deaf_to or {}, -1

    def _handshake(self, number: int) -> None:
        self._packets += 1
        if self._packets not in self._misses:
            super()._handshake(number)

    def _obey(self, number: int, argument: Optional[int], now_ns: int) -> None:
        if self._deaf_to.get(number, 0):
            self._deaf_to[number] -= 1
        else:
            super()._obey(number, argument, now_ns)


@pytest.mark.parametrize("misses", [(1,), (2,), (3,), (1, 4), (2, 5), (3, 6), (1, 4, 7)])
def test_what_the_robot_misses_of_the_handshake_is_said_again(scene: MakeScene, misses: tuple[int, ...]) -> None:
    made = scene(Forgetful(misses)).started()
    assert made.driver.health.state is HealthState.OK
    assert len(made.told(Command.STOP)) == 2  # in the search and in the session: no other speed was tried meanwhile


def test_names_that_are_cut_short_are_asked_for_again(scene: MakeScene) -> None:
    class Stammering(ScriptedPioneer):
        def _handshake(self, number: int) -> None:
            self.identity = IDENTITY if self.told.count((2, None)) > 1 else IDENTITY[:5]
            super()._handshake(number)

    made = scene(Stammering()).started()
    assert made.driver.info is not None
    assert made.driver.info.identity.name == "scripted"


def test_a_robot_that_does_not_change_its_speed_is_driven_at_its_own(scene: MakeScene) -> None:
    made = scene(Forgetful(deaf_to={Command.HOSTBAUD: 1})).started()
    assert made.told(Command.HOSTBAUD) == [2]
    assert made.link.baudrate == 9600
    assert made.run(1.0)


def test_a_robot_that_changes_to_another_speed_than_it_was_told_is_lost_and_found_again(scene: MakeScene) -> None:
    class Astray(ScriptedPioneer):
        def _obey(self, number: int, argument: Optional[int], now_ns: int) -> None:
            first = self.told.count((number, argument)) == 1
            super()._obey(number, 4 if number == Command.HOSTBAUD and first else argument, now_ns)

    made = scene(Astray())
    with pytest.raises(RobotError, match="fell silent when its line was to change to 38400 baud"):
        made.driver.start()
    made.driver.start()
    assert made.link.baudrate == 38400


def test_motors_are_enabled_again_where_the_robot_missed_it(scene: MakeScene) -> None:
    made = scene(Forgetful(deaf_to={Command.ENABLE: 2})).started()
    assert made.told(Command.ENABLE) == [1, 1, 1]
    assert made.driver.health.state is HealthState.OK


def test_parameters_are_asked_for_until_they_come(scene: MakeScene) -> None:
    made = scene(Forgetful(deaf_to={Command.CONFIG: 1})).started()
    assert made.told(Command.CONFIG) == [1, 1]
    assert made.driver.info is not None
    assert made.driver.info.parameters is not None


@pytest.mark.parametrize("head", [b"\xfa\xfb", b"\xfa\xfb\xc8", b"\xfa\xfb\xc8\x32\x00"])
def test_a_packet_that_never_ends_holds_up_no_other(scene: MakeScene, head: bytes) -> None:
    made = scene(faster_baudrate=None).started()
    made.run(0.5)
    made.robot.say = [head]
    began_ns = made.clock()
    assert len(made.run(0.5)) >= 4
    made.robot.say = [head]
    while not (states := made.driver.poll()):
        pass
    assert made.clock() - states[-1].stamp_ns < 0.1 * S
    assert made.clock() - began_ns < 0.8 * S


def test_over_a_network_no_speeds_are_tried(scene: MakeScene, tmp_path: Path) -> None:
    made = scene()
    driver = over_a_network(made, tmp_path)
    made.robot.off = True
    began_ns = made.clock()
    with pytest.raises(RobotError, match=r"socket://10\.0\.0\.2:8101: expected a Pioneer, got no answer$"):
        driver.start()
    assert made.clock() - began_ns < S


def test_over_a_network_there_is_no_speed_to_change_and_none_to_reckon_with(scene: MakeScene, tmp_path: Path) -> None:
    made = scene()
    driver = over_a_network(made, tmp_path)
    driver.start()
    assert made.told(Command.HOSTBAUD) == []
    assert driver.info is not None
    assert driver.info.baudrate is None
    while not (states := driver.poll()):
        pass
    assert made.clock() == states[-1].stamp_ns


def over_a_network(made, folder: Path) -> Pioneer:
    link = Link("socket://10.0.0.2:8101", 9600, lock_folder=folder, clock=made.clock)
    return Pioneer(link, PioneerConfig(), BaseConfig(), made.clock, made.line.pause)
