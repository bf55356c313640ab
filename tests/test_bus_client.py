# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion.connect`: what a laptop reads of a robot, and what it can tell it to do."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from contextlib import suppress
from itertools import islice
from typing import Any, Iterator, List

import msgspec
import pytest

import edgefusion
from bus_base import LIMITS, STAMPER, Base, detection, report
from bus_lab import Lab, until
from edgefusion.bus import topics
from edgefusion.bus.client import Errand, Robot
from edgefusion.bus.freshness import Freshness
from edgefusion.bus.inbox import Inbox
from edgefusion.bus.liveliness import declare_alive
from edgefusion.bus.publisher import CommandPublisher, Publisher
from edgefusion.bus.requests import GoalRequest, GotoRequest, InspectRequest, ResumeRequest, StopRequest
from edgefusion.bus.session import UnreachableError
from edgefusion.bus.tags import Tagger
from edgefusion.errors import RefusedError
from edgefusion.messages.from_battery import from_battery
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.from_healths import from_healths
from edgefusion.messages.from_mission import from_mission
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_cmd_vel import to_cmd_vel
from edgefusion.types import Health, HealthState, Twist2D


@pytest.fixture
def base(lab: Lab) -> Base:
    return Base(lab)


@pytest.fixture
def robot(lab: Lab, base: Base) -> Iterator[Robot]:
    with edgefusion.connect(lab.tcp) as robot:
        yield robot


def test_detections_come_as_the_robot_has_seen_them(base: Base, robot: Robot) -> None:
    seen = robot.detections(timeout_s=60)
    base.say(topics.DETECTIONS_DETAIL, from_detections_detail(7, [detection(7, 2.0), detection(7, 3.0)]))
    base.say(topics.DETECTIONS_DETAIL, from_detections_detail(8, []))
    base.say(topics.DETECTIONS_DETAIL, from_detections_detail(9, [detection(9, 4.0)]))
    found = list(islice(seen, 3))
    assert [(each.stamp_ns, each.distance_m) for each in found] == [(7, 2.0), (7, 3.0), (9, 4.0)]
    assert found[0].vote == detection(7).vote
    assert found[0].cluster.indices.tolist() == [4, 5]


def test_a_frame_without_an_object_is_a_frame_too(base: Base, robot: Robot) -> None:
    frames = robot.frames(timeout_s=60)
    base.say(topics.DETECTIONS_DETAIL, from_detections_detail(8, []))
    assert next(frames) == (8, ())


def test_nonsense_on_a_topic_is_left_out(base: Base, robot: Robot, caplog: pytest.LogCaptureFixture) -> None:
    missions = robot.missions(timeout_s=60)
    base.say(topics.MISSION, from_mission(report(1, "driving", "a")))
    assert next(missions) == report(1, "driving", "a")
    for topic in (topics.MISSION, topics.DIAGNOSTICS, topics.BATTERY):
        for payload in (b"", b"\x00\x01", b"\xff" * 300):
            base.session.put(topics.key_of("robot", topic.name), payload)
    base.say(topics.MISSION, from_mission(report(2, "arrived")))
    assert next(missions) == report(2, "arrived")

    def arrived() -> bool:  # said again and again, as base does: of what comes at once the newest is kept
        base.say(topics.MISSION, from_mission(report(2, "arrived")))
        return robot.status.mission == report(2, "arrived")

    until(arrived, 60)
    until(lambda: (robot.status.battery, robot.status.healths) == (None, ()) and "left out" in caplog.text, 60)


def test_silence_is_said_after_the_time_that_was_given(robot: Robot) -> None:
    with pytest.raises(UnreachableError, match="nothing came for"):
        next(robot.detections(timeout_s=0.05))


def test_who_waits_is_let_go_when_the_robot_is_closed(lab: Lab, base: Base) -> None:
    robot, ended = edgefusion.connect(lab.tcp), threading.Event()
    threading.Thread(target=lambda: (list(robot.detections()), ended.set()), daemon=True).start()
    time.sleep(0.05)
    robot.close()
    assert ended.wait(60)


def test_the_status_is_what_the_robot_said_last(base: Base, robot: Robot) -> None:
    assert robot.status == (None, None, (), None, frozenset())
    token = declare_alive(base.session, "robot", "base")
    base.say(topics.MISSION, from_mission(report(1, "driving", "a")))
    base.say(topics.MISSION, from_mission(report(2, "arrived")))
    base.say(topics.BATTERY, from_battery(1, 12.5, STAMPER))
    camera = Health("camera", HealthState.FAILED, "unplugged")
    base.say(topics.DIAGNOSTICS, from_healths(1, [camera], STAMPER))
    until(lambda: robot.status.mission == report(2, "arrived") and robot.status.healths and robot.status.battery)
    until(lambda: robot.status.alive)
    status = robot.status
    assert status.battery is not None and status.age_s is not None
    assert [each.health for each in status.healths] == [camera]
    assert (status.battery.voltage_v, status.alive) == (12.5, {"base"})
    assert 0 <= status.age_s < 60
    token.undeclare()


def test_goto_gives_what_the_robot_has_accepted(base: Base, robot: Robot) -> None:
    errand = robot.goto(5, 5.5, 0.26, inspect=["oscilloscope"])
    (request,) = base.asked
    assert request == GotoRequest((GoalRequest(5, 5.5, 0.26, id=errand.goal_ids[0]),), ("oscilloscope",))
    assert errand.since_ns == 1000
    again = robot.goto_all([GoalRequest(1, 2, id="mine"), GoalRequest(3, 4, frame="base_link")])
    assert again.goal_ids[0] == "mine"
    assert len({*errand.goal_ids, *again.goal_ids}) == 3


def test_a_refusal_is_raised_with_its_reason(base: Base, robot: Robot) -> None:
    base.refusal = "robot: the battery is low: 11.2 V"
    with pytest.raises(RefusedError, match=r"mission/goto: refused: robot: the battery is low: 11\.2 V"):
        robot.goto(5, 5)


def test_what_makes_no_sense_is_refused_before_it_is_sent(base: Base, robot: Robot) -> None:
    with pytest.raises(RefusedError, match="x_m"):
        robot.goto(float("inf"), 5)
    with pytest.raises(RefusedError, match="mission/goto"):
        robot.goto_all([])
    with pytest.raises(RefusedError, match="reason"):
        robot.stop("x" * 201)
    assert not base.asked


def test_stop_resume_and_inspect_are_asked_of_the_robot(base: Base, robot: Robot) -> None:
    robot.stop("a cat", cancel=True)
    robot.resume()
    robot.inspect(["oscilloscope"])
    assert base.asked == [StopRequest("a cat", True), ResumeRequest(), InspectRequest(("oscilloscope",))]


def test_without_a_base_nobody_answers(lab: Lab) -> None:
    with edgefusion.connect(lab.tcp) as robot:
        for command in (robot.stop, lambda: robot.drive(Twist2D(0.1))):
            with pytest.raises(UnreachableError, match="is the base running"):
                command()


@pytest.mark.parametrize(
    ("said", "given"),
    [
        (["driving", "inspecting", "stopped", "driving", "arrived"], 5),
        (["driving", "blocked", "blocked"], 2),
        (["driving", "idle", "idle"], 2),
        (["driving", "stopped", "given up", "given up"], 3),
    ],
)
def test_progress_ends_when_the_mission_does(base: Base, robot: Robot, said: List[Any], given: int) -> None:
    base.say(topics.MISSION, from_mission(report(998, "arrived")))
    progress = robot.progress(Errand(("a",), 1000))
    base.say(topics.MISSION, from_mission(report(999, "arrived")))  # it is of what was before
    for number, state in enumerate(said):
        goal_id = "a" if state not in ("arrived", "idle", "blocked", "given up") else ""
        state = "stopped" if state == "given up" else state  # as after a failure of the robot
        base.say(topics.MISSION, from_mission(report(1000 + number, state, goal_id)))
    assert len(list(progress)) == given


def test_progress_ends_when_somebody_gives_other_goals(base: Base, robot: Robot) -> None:
    base.say(topics.MISSION, from_mission(report(0, "driving", "a")))
    progress = robot.progress(Errand(("a",), 1))
    for goal_id in ("a", "b", "b"):
        base.say(topics.MISSION, from_mission(report(1, "driving", goal_id)))
    assert [each.goal_id for each in progress] == ["a", "b"]


def test_drive_commands_a_velocity_that_counts(base: Base, robot: Robot) -> None:
    inbox = Inbox(base.session, "robot", topics.CMD_VEL, to_cmd_vel, Freshness(LIMITS))
    told: List[Twist2D] = []

    def counts() -> bool:  # again and again, as drive() is to be called: one that was found late is old
        driven(robot, Twist2D(0.2, -0.1))
        told.extend(twist for _, twist in inbox.take(time.monotonic_ns()))
        return bool(told)

    until(counts, 60)
    assert set(told) == {Twist2D(0.2, -0.1)}


def driven(robot: Robot, twist: Twist2D) -> None:
    with suppress(UnreachableError):  # not known there yet
        robot.drive(twist)


def test_attending_beats_until_it_ends(base: Base, robot: Robot) -> None:
    inbox = Inbox(base.session, "robot", topics.HEARTBEAT, lambda message: message.data, Freshness(LIMITS))
    last = CommandPublisher(robot.session, "robot", topics.HEARTBEAT, Tagger(), 5000)
    until(lambda: last.heard, 60)
    with robot.attend():
        until(lambda: inbox.waiting >= 3, 60)
    # The beats that are still on their way come before it; the router drops what comes right after one of them.
    until(lambda: (last.put(String("last")), "last" in [beat for _, beat in inbox.take(0)])[1], 60)
    time.sleep(0.3)
    assert {beat for _, beat in inbox.take(0)} <= {"last"}


def test_the_laptops_part_loads_neither_the_core_nor_the_runtime() -> None:
    code = (
        "import sys, edgefusion; assert 'zenoh' not in sys.modules; edgefusion.connect; import edgefusion.bus.router; "
        "print([m for m in ('edgefusion._core', 'onnxruntime', 'cv2', 'cryptography') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_program_that_closes_nothing_ends_all_the_same(lab: Lab, base: Base) -> None:
    """Also while it is told something."""
    over = threading.Event()
    publisher = Publisher(base.session, "robot", topics.MISSION, Tagger(), "boot")

    def talk() -> None:
        while not over.wait(0.0005):
            publisher.put(from_mission(report(1, "driving")), 0)

    talking = threading.Thread(target=talk)
    talking.start()
    code = f"import edgefusion; robot = edgefusion.connect({lab.tcp!r}); robot.stop(); found = robot.detections()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    over.set()
    talking.join()
    assert (done.returncode, done.stderr) == (0, "")
    assert base.asked == [StopRequest()]


def test_requests_and_answers_are_strict_json() -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.json.decode(b'{"goals":[{"x_m":1,"y_m":2,"z_m":3}]}', type=GotoRequest)
