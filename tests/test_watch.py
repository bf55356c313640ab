# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion watch` and `topics`: what a robot says, told to who has no more than a viewer's keys."""

from __future__ import annotations

import json
import os
import pty
import select
import signal
import subprocess
import sys
import threading
from typing import Any, Callable, Dict

import pytest

from bus_base import STAMPER, Base, Speaker, detection, report
from bus_lab import Lab, until
from edgefusion.bus import topics
from edgefusion.bus.healths import SILENT_NS, Healths
from edgefusion.bus.listener import Listener
from edgefusion.bus.liveliness import declare_alive
from edgefusion.cli import main
from edgefusion.clock import system_clock
from edgefusion.messages.cdr import encode
from edgefusion.messages.from_battery import from_battery
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.from_healths import from_healths
from edgefusion.messages.from_mission import from_mission
from edgefusion.messages.sensor_msgs import LaserScan
from edgefusion.messages.std_msgs import String
from edgefusion.tools.topic_rates import listen
from edgefusion.tools.watch_loop import Watch
from edgefusion.tools.watch_report import in_words
from edgefusion.types import Health, HealthState

COMMAND = [sys.executable, "-m", "edgefusion.cli"]
S = 1_000_000_000
SCAN = LaserScan(ranges=[1.0] * 361)


@pytest.fixture
def base(lab: Lab) -> Base:
    return Base(lab)


def say_everything(base: Base) -> None:
    base.say(topics.MISSION, from_mission(report(1, "driving", "a")))
    base.say(topics.BATTERY, from_battery(1, 12.5, STAMPER))
    camera = Health("camera", HealthState.FAILED, "unplugged")
    base.say(topics.DIAGNOSTICS, from_healths(1, [camera], STAMPER, {"camera": {"capture_ms": "4.1"}}))
    base.say(topics.DETECTIONS_DETAIL, from_detections_detail(7, [detection(7, 3.0), detection(7, 2.0)]))


class Saying:
    """Within it, something is said again and again, as robots do."""

    def __init__(self, say: Callable[[], None]) -> None:
        self._say, self._ended = say, threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._ended.wait(0.02):
            self._say()


def test_watch_tells_everything_once(lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]) -> None:
    token = declare_alive(base.session, "robot", "base")
    with Saying(lambda: say_everything(base)):
        assert main(["watch", "--once", "--connect", lab.tcp]) == 0
    token.undeclare()
    lines = capsys.readouterr().out.splitlines()
    assert lines[:4] == [
        "robot    robot: base alive",
        "mission  driving, goal a",
        "pose     not known yet",
        "battery  12.5 V",
    ]
    assert lines[4].startswith("objects  2 in the newest frame")
    assert lines[5].split() == [
        "oscilloscope",
        "(instrument)",
        *["2.00", "m", "+-0.02", "6", "deg", "left", "score", "0.90"],
    ]
    assert lines[6].split()[2] == "3.00"
    assert lines[7] == "camera   failed: unplugged (capture_ms 4.1)"
    assert max(map(len, lines)) < 100


def test_watch_as_json_tells_the_same_for_programs(lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]) -> None:
    with Saying(lambda: say_everything(base)):
        assert main(["watch", "--json", "--seconds", "1.5", "--connect", lab.tcp]) == 0
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    last = told[-1]
    assert last["mission"]["state"] == "driving" and 0 <= last["mission_age_s"] < 60
    assert [each["distance_m"] for each in last["seen"]["detections"]] == [3.0, 2.0]
    assert last["seen"]["stamp_ns"] == 7 and last["seen"]["frames_per_s"] > 0
    assert last["components"] == [
        {"name": "camera", "state": "failed", "reason": "unplugged", "figures": {"capture_ms": "4.1"}}
    ]
    assert last["battery"] == {"voltage_v": 12.5, "charging": None}


def test_a_robot_that_says_nothing_is_told_as_that(lab: Lab, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["watch", "--once", "--connect", lab.tcp]) == 1
    assert capsys.readouterr().out.splitlines()[:2] == [
        "robot    robot: nothing of it is alive on this bus",
        "mission  nothing heard",
    ]


def test_where_there_is_no_router_it_is_said_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["watch", "--once", "--connect", "tcp/127.0.0.1:9"]) == 1
    err = capsys.readouterr().err
    assert err.startswith("edgefusion: tcp/127.0.0.1:9: no router let us in") and err.count("\n") == 1


def test_what_two_processes_say_of_their_components_is_told_together(lab: Lab, base: Base) -> None:
    vision = Speaker(lab.member())
    now_ns = [0]
    healths = Healths(lab.client(), "robot", lambda: now_ns[0])
    base.say(topics.DIAGNOSTICS, from_healths(1, [Health("laser", HealthState.OK)], STAMPER))
    vision.say(topics.DIAGNOSTICS, from_healths(1, [Health("camera", HealthState.OK)], STAMPER))
    until(lambda: len(healths.reports) == 2)
    now_ns[0] = SILENT_NS - S
    base.say(topics.DIAGNOSTICS, from_healths(1, [Health("laser", HealthState.DEGRADED, "dust")], STAMPER))
    until(lambda: healths.reports[1].health.reason == "dust")
    now_ns[0] = SILENT_NS + S
    camera, laser = healths.reports
    assert (camera.health.state, camera.health.reason) == (HealthState.FAILED, "nothing heard for 4 s")
    assert laser.health == Health("laser", HealthState.DEGRADED, "dust")


def test_what_is_old_is_told_with_its_age(lab: Lab, base: Base) -> None:
    now_ns = [0]
    robot = Listener(lab.client(), "robot", lambda: now_ns[0])
    watch = Watch(robot, lambda: now_ns[0])
    say_everything(base)
    until(lambda: watch.look().says_everything)
    now_ns[0] = 9 * S
    told = "\n".join(in_words(watch.look()))
    assert "driving, goal a; told 9 s ago" in told
    assert "0.0 frames/s; it came 9 s ago" in told
    assert "camera   failed: nothing heard for 9 s" in told


def test_a_frame_that_is_none_is_left_out_and_those_after_it_are_told(
    lab: Lab, base: Base, caplog: pytest.LogCaptureFixture
) -> None:
    watch = Watch(Listener(lab.client(), "robot"), system_clock)
    newer = String('{"version": 99, "frame": "of a robot that is newer than this laptop"}')
    base.say(topics.DETECTIONS_DETAIL, newer)
    base.say(topics.DETECTIONS_DETAIL, newer)
    base.say(topics.DETECTIONS_DETAIL, from_detections_detail(7, [detection(7, 3.0)]))
    until(lambda: watch.look().seen)
    seen = watch.look().seen
    assert seen is not None and (seen.frame.stamp_ns, len(seen.frame.detections)) == (7, 1)
    (said,) = caplog.messages
    assert said.startswith("detections/detail: left out, and from now on only counted: ")


def test_topics_that_is_ended_before_it_has_listened_gives_no_answer(lab: Lab, base: Base) -> None:
    command = [*COMMAND, "topics", "--seconds", "60", "--connect", lab.tcp]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        heard = base.session.declare_publisher("robot/mission")
        until(lambda: heard.matching_status.matching, 60)  # it listens
        process.send_signal(signal.SIGTERM)
        out, _ = process.communicate(timeout=60)
    assert (process.returncode, out) == (130, "")


def test_in_a_terminal_the_table_is_drawn_in_place_until_ctrl_c(lab: Lab, base: Base) -> None:
    end, inside = pty.openpty()
    command = [*COMMAND, "watch", "--connect", lab.tcp]
    with Saying(lambda: say_everything(base)), subprocess.Popen(command, stdout=inside, stderr=inside) as process:
        shown = bytearray()

        def is_drawn_again() -> bool:
            shown.extend(os.read(end, 65536) if select.select([end], [], [], 0)[0] else b"")
            return b"camera   failed: unplugged" in shown and b"\x1b[9A" in shown

        until(is_drawn_again, 60)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 130
    os.close(end), os.close(inside)


def test_topics_tells_names_types_and_rates(lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]) -> None:
    told: Dict[str, Any] = {}

    def hears_enough() -> bool:  # of few a busy machine says nothing about a rate: they may come all at once
        assert main(["topics", "--json", "--seconds", "1", "--connect", lab.tcp]) == 0
        told.update({each["topic"]: each for each in map(json.loads, capsys.readouterr().out.splitlines())})
        return told["scan"]["messages"] >= 10

    with Saying(lambda: base.say(topics.SCAN, SCAN)):
        until(hears_enough, 60)
    assert set(told) == set(topics.TOPICS)
    scan = told["scan"]
    assert (scan["type"], scan["direction"]) == ("sensor_msgs/msg/LaserScan", "out")
    assert 1 < scan["rate_hz"] <= 120  # 50 are said in a second; half of the time the first may have been held up
    weighed = scan["bytes_per_s"] / len(encode(SCAN))  # what came at the very end of this second was not any more
    assert weighed == round(weighed) and scan["messages"] / 2 <= weighed <= scan["messages"]
    assert (told["cmd_vel"]["direction"], told["cmd_vel"]["messages"]) == ("in", 0)


def test_topics_is_a_table_for_people(lab: Lab, base: Base, capsys: pytest.CaptureFixture[str]) -> None:
    with Saying(lambda: base.say(topics.SCAN, SCAN)):
        assert main(["topics", "--seconds", "0.5", "--connect", lab.tcp]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["topic", "type", "Hz", "kB/s"]
    assert lines[1].split()[:2] == ["scan", "sensor_msgs/msg/LaserScan"]
    assert next(line for line in lines if line.startswith("odom ")).split()[-2:] == ["-", "-"]
    assert any(line.startswith("> cmd_vel ") for line in lines)


def test_the_type_is_what_the_messages_say(lab: Lab) -> None:
    session = lab.member()
    with Saying(lambda: session.put("robot/scan", b"\0" * 8, encoding="application/cdr;my_msgs/msg/Scan")):
        (scan, *_) = listen(lab.client(), "robot", 0.5)
    assert scan.type == "my_msgs/msg/Scan"
