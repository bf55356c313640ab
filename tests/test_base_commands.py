# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What people want of a robot over the bus: which of it moves the robot, and what does not."""

from __future__ import annotations

import itertools
import math
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pytest

from base_lab import wait_for
from bus_robot import BusRobot, agrees, given_up
from edgefusion.bus.publisher import CommandPublisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL, GOAL_POSE
from edgefusion.errors import RefusedError
from edgefusion.messages.from_cmd_vel import from_cmd_vel
from edgefusion.messages.from_goal_pose import from_goal_pose
from edgefusion.messages.geometry_msgs import Twist, Vector3
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Pose2D, Twist2D

AHEAD = Twist2D(0.2)
LOST_TURNS = 30
"""After so many velocities, ten in a second, a robot that does not move was lost by a machine that is too busy, and has
its motors off until a resume."""

TTL_MS = 5000
"""Of commands that are put once: a base that is late takes them all the same."""


@pytest.fixture(scope="module")
def it(tmp_path_factory):
    """One robot for all tests; each leaves it at rest, with nothing to do."""
    with BusRobot(tmp_path_factory.mktemp("robot")) as robot:
        robot.start("bus", "base")
        yield robot


@pytest.fixture
def robot(it):
    """It is well, its mission idle, and nothing is stopped."""
    robot = it.connect()
    it.go(robot, it.lab.pose.x_m)
    make_idle(robot)
    yield robot
    wait_for(lambda: agrees(lambda: robot.stop("the test is over", cancel=True)))
    wait_for(lambda: not it.moving(0.0))


def make_idle(robot) -> None:
    """It has no goal, and nothing is stopped."""
    wait_for(lambda: agrees(lambda: robot.stop("test", cancel=True)) and agrees(robot.resume))
    wait_for(lambda: robot.status.mission and robot.status.mission.state == "idle")


def ahead_m(robot, way_m: float) -> float:
    """From where it believes to be."""
    return robot.status.mission.pose[0] + way_m


def drive_until(it: BusRobot, robot, holds) -> None:
    """An operator drives, ten times a second, until something is so."""

    def driven() -> bool:
        with suppress(ConnectionError):  # not known there yet
            robot.drive(AHEAD)
        time.sleep(0.1)
        return bool(holds())

    wait_for(driven)


def drive_off(it: BusRobot, robot) -> None:
    """An operator drives until the robot does."""
    turns = itertools.count(1)

    def moves() -> bool:
        if next(turns) % LOST_TURNS == 0:
            agrees(robot.resume)
        return it.moving(0.1)

    drive_until(it, robot, moves)


def test_a_velocity_that_is_no_longer_published_stops_the_robot_within_the_deadman_and_a_cycle(it, robot) -> None:
    drive_off(it, robot)
    drive_until(it, robot, lambda: it.moving(0.15) and robot.status.mission.paused)
    stopped_s = it.stopped_after_s(time.monotonic_ns())
    assert stopped_s < 10.0  # 0.3 s on a machine with nothing else to do


def test_an_operator_pauses_the_mission_until_resume_and_then_it_goes_on_to_its_goal(it, robot) -> None:
    goal_m = ahead_m(robot, 0.8)
    errand = it.drive(robot, goal_m, 0.1)
    drive_until(it, robot, lambda: robot.status.mission.paused)
    wait_for(lambda: not it.moving(0.0))
    mission = robot.status.mission
    assert (mission.state, mission.reason) == ("stopped", "an operator drives")
    robot.resume()
    assert it.arrive(robot, errand, goal_m)[-1] == "arrived"


def test_a_resume_right_after_a_velocity_gives_the_robot_back_to_its_mission(it, robot) -> None:
    publisher = CommandPublisher(robot.session, "robot", CMD_VEL, Tagger(), TTL_MS)
    wait_for(lambda: publisher.heard)
    drive_until(it, robot, lambda: robot.status.mission.paused)
    for _ in range(5):
        publisher.put(from_cmd_vel(Twist2D()))
        robot.resume()  # nobody has looked at the velocity yet
    since_ns = time.monotonic_ns() + 50_000_000
    report = next(report for report in robot.missions(30.0) if report.stamp_ns > since_ns)
    assert not report.paused
    assert report.state == "idle"


def test_a_stop_beats_an_operator_until_resume(it, robot) -> None:
    drive_off(it, robot)
    robot.stop("look out")
    since_ns = time.monotonic_ns() + 200_000_000  # what was computed before
    end_s = time.monotonic() + 0.6
    drive_until(it, robot, lambda: time.monotonic() > end_s)
    assert it.velocities(since_ns) <= {0}
    wait_for(lambda: robot.status.mission.reason == "look out")
    robot.resume()
    drive_off(it, robot)


def test_it_is_told_whether_the_threads_that_drive_have_real_time(robot) -> None:
    def told() -> list[str]:
        base = [each.figures for each in robot.status.healths if each.health.component == "base"]
        return [figures["real time"] for figures in base]

    wait_for(told)
    assert told() in (["0 of 3 threads"], ["3 of 3 threads"])


@pytest.mark.parametrize("x_mps", [math.nan, math.inf, -math.inf])
def test_a_velocity_that_is_none_is_refused_and_counted_and_moves_nothing(it, robot, x_mps: float) -> None:
    since_ns = time.monotonic_ns()
    publisher = CommandPublisher(robot.session, "robot", CMD_VEL, Tagger(), TTL_MS)
    wait_for(lambda: publisher.heard)

    def refused() -> int:
        figures = next((each.figures for each in robot.status.healths if each.health.component == "base"), {})
        return int(figures.get("cmd_vel refused, malformed", 0))

    before = refused()
    publisher.put(Twist(Vector3(x=x_mps)))
    wait_for(lambda: refused() > before)
    assert it.velocities(since_ns) <= {0}
    assert not robot.status.mission.paused


def test_a_velocity_over_the_limit_is_driven_at_the_limit(it, robot) -> None:
    publisher = CommandPublisher(robot.session, "robot", CMD_VEL, Tagger(), 200)
    wait_for(lambda: publisher.heard)
    since_ns = time.monotonic_ns()

    def driven() -> bool:
        publisher.put(Twist(Vector3(x=-30.0)))
        time.sleep(0.05)
        return len(it.velocities(since_ns) - {0}) > 0

    wait_for(driven)
    assert min(it.velocities(since_ns)) >= -500


def test_a_goal_pose_is_driven_to_and_one_in_another_frame_is_not(it, robot) -> None:
    publisher = CommandPublisher(robot.session, "robot", GOAL_POSE, Tagger(), TTL_MS)
    wait_for(lambda: publisher.heard)
    before, goal = it.lab.pose.x_m, from_goal_pose(0, Pose2D(0.3), Stamper(), "base_link")
    publisher.put(from_goal_pose(0, Pose2D(0.4), Stamper(), "map"))
    publisher.put(goal)
    wait_for(lambda: robot.status.mission.goal_id == "goal_pose-1")

    def arrived() -> bool:
        mission = robot.status.mission
        if given_up(mission):  # the machine is too busy
            agrees(robot.resume)
            publisher.put(goal)
            wait_for(lambda: robot.status.mission.stamp_ns > mission.stamp_ns)
        return mission.state == "arrived"

    wait_for(arrived)
    assert it.lab.pose.x_m > before + 0.1


def test_what_cannot_be_done_is_refused_with_the_reason(robot) -> None:
    with pytest.raises(RefusedError, match="expected a mission that is stopped"):
        robot.resume()
    with pytest.raises(RefusedError, match="mission/goto"):
        robot.goto(1e6, 0.0)


def test_who_interrupts_goto_stops_the_robot_and_it_has_no_goal_any_more(it, robot) -> None:
    command = [sys.executable, "-m", "edgefusion.cli", "goto", "0.6", "0", "--relative", "--connect", it.endpoint]

    def start() -> None:
        it.processes["goto"] = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)

    def sets_off() -> bool:
        busy = it.processes["goto"].poll() is not None or robot.status.mission.state == "stopped"
        if busy:  # the machine: its goal was given up
            it.processes["goto"].kill()
            it.processes["goto"].communicate()
            make_idle(robot)
            start()
        return it.moving(0.1)

    start()
    wait_for(sets_off)
    since_ns = time.monotonic_ns()
    process = it.processes["goto"]
    process.send_signal(signal.SIGINT)
    assert it.stopped_after_s(since_ns) < 10.0  # 0.1 s on a machine with nothing else to do
    _, err = process.communicate(timeout=60)
    assert (process.returncode, err.count("called off: the robot stands")) == (130, 1)
    wait_for(lambda: robot.status.mission.reason == "its operator interrupted the drive")
    since_ns = time.monotonic_ns()
    robot.resume()
    wait_for(lambda: robot.status.mission.state == "idle")
    assert it.velocities(since_ns) <= {0}


def test_a_router_that_is_killed_costs_the_base_nothing_and_it_is_back_on_the_next_one(it, robot) -> None:
    it.drive(robot, ahead_m(robot, 1.0), 0.1)
    it.end("bus", signal.SIGKILL)
    time.sleep(0.5)
    assert it.processes["base"].poll() is None
    it.start("bus")
    again = it.connect()
    report = next(again.missions(30.0))
    simulator_was_late = "nothing came for" in report.reason  # of a base that is, all the robot said waits to be read
    assert report.state in ("driving", "arrived") or simulator_was_late
    assert report.goal_id or report.state == "arrived" or simulator_was_late
