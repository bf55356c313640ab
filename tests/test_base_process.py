# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion bus` and `edgefusion base` as processes, with a simulated robot: however they end, it stands."""

from __future__ import annotations

import os
import signal
import time

import pytest

from base_lab import wait_for
from bus_robot import STOPS, BusRobot
from edgefusion.bus import topics
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_odometry import to_odometry
from edgefusion.messages.to_scan import to_scan
from edgefusion.types import HealthState


def test_a_goal_from_a_client_is_driven_to_and_reported_until_it_arrives(tmp_path) -> None:
    with BusRobot(tmp_path) as it:
        robot = it.start("bus", "base").connect()
        errand = it.go(robot, 0.6)
        assert {"driving", "arrived"} == set(it.arrive(robot, errand, 0.6))
        was_lost = it.was_late(errand.since_ns)  # how far it rolled then nobody knows
        assert was_lost or abs(it.lab.pose.x_m - 0.6) < 0.06
        assert robot.status.alive == {"bus", "base"}
        assert {report.health.component for report in robot.status.healths} == {"robot", "laser", "base"}
        scan = next(robot.read(topics.SCAN, lambda message: to_scan(message, Stamper()), 30.0))
        assert len(scan.ranges_m) == 361
        odometry = next(robot.read(topics.ODOM, lambda message: to_odometry(message, Stamper()), 30.0))
        assert abs(odometry.pose.x_m - 0.6) < 0.06
        path = next(robot.read(topics.PATH, lambda message: message, 30.0))
        assert path.poses == []  # it is there
        assert it.end("base") == 0
        assert it.end("bus") == 0


def test_a_base_whose_keys_will_not_do_ends_at_once_as_nobody_could_stop_it(tmp_path) -> None:
    with BusRobot(tmp_path, 'keys = "/nowhere"') as it:
        assert it.start("base").processes["base"].wait(30) == 2


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_base_that_is_told_to_end_while_it_drives_stops_its_robot_last(tmp_path, number: int) -> None:
    with BusRobot(tmp_path) as it:
        it.drive(it.start("bus", "base").connect())
        assert it.end("base", number) == 0
        wait_for(lambda: not it.lab.robot.open)
        assert it.last_motion() in STOPS


def test_a_base_that_was_halted_for_a_second_says_first_to_stop(tmp_path) -> None:
    with BusRobot(tmp_path) as it:
        robot = it.start("bus", "base").connect()
        errand = it.drive(robot)
        it.processes["base"].send_signal(signal.SIGSTOP)
        time.sleep(1.0)
        since_ns = time.monotonic_ns()
        it.processes["base"].send_signal(signal.SIGCONT)
        wait_for(lambda: it.lab.motions()[-1][0] >= since_ns)
        first = next(told for told in it.lab.motions() if told[0] >= since_ns)
        assert first[1:] in STOPS
        it.at_speed(robot, errand, speed_mps=0.1)  # it is well, and goes on


def test_what_an_operator_has_stopped_stays_so_when_base_is_killed_until_they_resume(tmp_path) -> None:
    with BusRobot(tmp_path) as it:
        robot = it.start("run").connect()
        it.drive(robot)
        robot.stop("there is a child 停")
        os.kill(it.child_of("run", "base"), signal.SIGKILL)
        wait_for(lambda: "base" not in robot.status.alive)
        since_ns = time.monotonic_ns()
        errand = it.go(robot, leave_stop=False)

        def stands() -> bool:
            mission = robot.status.mission
            told = mission.state, mission.reason
            return mission.stamp_ns >= errand.since_ns and told == ("stopped", "there is a child 停")

        wait_for(stands)
        assert it.velocities(since_ns) <= {0}
        robot.resume()
        it.at_speed(robot, errand)


def test_a_base_that_is_killed_at_speed_is_stopped_for_and_its_robot_stays_when_it_is_back(tmp_path) -> None:
    with BusRobot(tmp_path) as it:
        robot = it.start("run").connect()
        it.drive(robot)
        os.kill(it.child_of("run", "base"), signal.SIGKILL)
        killed_ns = time.monotonic_ns()  # what base had written may be read after that
        stopped_ns = killed_ns + round(it.stopped_after_s(killed_ns) * 1e9)
        for well in (False, True):
            wait_for(lambda: all(each.health.state is HealthState.OK for each in robot.status.healths) is well)  # noqa: B023
        assert it.velocities(stopped_ns) <= {0}
        assert it.end("run") == 0
        wait_for(lambda: not it.lab.robot.open)
        assert it.last_motion() in STOPS
