# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the supervisor is made of: signals as bytes, last stops in threads, the offset to UTC, its children."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from edgefusion.config import Config, ServiceConfig, VisionConfig
from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.errors import RefusedError
from edgefusion.service import utc
from edgefusion.service.child_spec import GiveUp
from edgefusion.service.children import children_of
from edgefusion.service.last_stop import RobotLine
from edgefusion.service.robot_stops import RobotStops
from edgefusion.service.signal_pipe import ENDS, SignalPipe

STATUS = {"port": "/dev/ttyUSB0", "baudrate": 38400}


def test_signals_are_seen_in_their_order_and_what_was_before_is_restored() -> None:
    before = [signal.getsignal(number) for number in ENDS]
    with SignalPipe() as pipe:
        assert pipe.take() == []
        for number in ENDS:
            os.kill(os.getpid(), number)
        pipe.wake()
        assert pipe.take() == list(ENDS)
        assert pipe.take() == []
    assert [signal.getsignal(number) for number in ENDS] == before
    pipe.wake()  # a thread that is late


def test_a_signal_that_is_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with SignalPipe() as pipe:
            os.kill(os.getpid(), signal.SIGHUP)
            assert pipe.take() == []
    finally:
        signal.signal(signal.SIGHUP, before)


def stopped_by(stop, status: dict[str, object], by_ns: int | None = None) -> list[tuple[str, bool]]:
    over = threading.Event()
    stops = RobotStops(over.set, stop)
    stops.begin("base", status, by_ns)
    assert over.wait(60)
    return list(stops.take())


def test_a_robot_is_stopped_where_its_status_says_and_in_the_time_that_is_left() -> None:
    asked = []

    def stop(line: RobotLine, by_ns: int | None) -> int:
        asked.append((line, by_ns))
        return 38400

    assert stopped_by(stop, STATUS, 7) == [("base", True)]
    assert asked == [(RobotLine("/dev/ttyUSB0", 38400), 7)]


@pytest.mark.parametrize("error", [RuntimeError("the port is gone"), RefusedError("no port"), ZeroDivisionError()])
def test_a_robot_that_may_still_move_is_told_of(error: Exception, caplog: pytest.LogCaptureFixture) -> None:
    def stop(line: RobotLine, by_ns: int | None) -> int:
        raise error

    assert stopped_by(stop, STATUS) == [("base", False)]
    assert "base: its robot may still move" in caplog.text


def test_a_robot_that_somebody_else_has_is_left_to_them(caplog: pytest.LogCaptureFixture) -> None:
    def stop(line: RobotLine, by_ns: int | None) -> int:
        raise PortBusyError("it is held by edgefusion robot")

    assert stopped_by(stop, STATUS) == [("base", True)]
    assert "base: its robot is left to who has it: it is held by edgefusion robot" in caplog.text


def test_a_status_that_names_no_line_is_told_of_and_one_without_a_robot_is_well(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def stop(line: RobotLine, by_ns: int | None) -> int:
        raise AssertionError("nothing to stop")

    assert stopped_by(stop, {"port": 3}) == [("base", False)]
    assert "expected the name of a port, got 3" in caplog.text
    assert stopped_by(stop, {"says": "starts"}) == [("base", True)]


def test_the_offset_to_utc_is_between_the_two_looks_at_the_clock() -> None:
    looks = iter([1000, 3000])
    assert utc.taken_offset_ns(lambda: next(looks), lambda: 1_000_000) == 998_000


def test_children_take_the_supervisors_offset_and_a_process_alone_takes_its_own() -> None:
    assert utc.utc_offset_ns({utc.ENVIRONMENT: "-12"}) == -12
    assert utc.utc_offset_ns({}, lambda: 10, lambda: 30) == 20
    with pytest.raises(RefusedError, match=r"expected whole nanoseconds, got '1\.5'"):
        utc.utc_offset_ns({utc.ENVIRONMENT: "1.5"})


def configured(**service: Any) -> Config:
    """One with a model."""
    return Config(service=ServiceConfig(**service), vision=VisionConfig(model="net", calibration="rig.toml"))


def test_the_children_are_what_the_configuration_says() -> None:
    config = configured(vision_failures=3, vision_failures_within_s=30.0, base_silence_s=1.0, longest_pause_s=2.0)
    bus, base, vision = children_of(config, Path("/etc/robot.toml"))
    assert base.argv == (sys.executable, "-m", "edgefusion.cli", "base", "--config", "/etc/robot.toml")
    assert (bus.drives, base.drives, vision.drives) == (False, True, False)
    assert (bus.required, base.required, vision.required) == (True, True, False)
    assert (bus.give_up, base.give_up, vision.give_up) == (None, None, GiveUp(3, 30.0))
    assert bus.nice == base.nice == 0 < vision.nice
    assert base.silence_s == 1.0 and base.longest_pause_s == 2.0


def test_only_what_this_machine_is_to_run_is_started() -> None:
    config = configured(processes=("bus", "base"))
    assert [spec.name for spec in children_of(config, Path("robot.toml"))] == ["bus", "base"]


def test_without_a_model_there_is_no_vision() -> None:
    assert [spec.name for spec in children_of(Config(), Path("robot.toml"))] == ["bus", "base"]


@pytest.mark.parametrize(
    ("processes", "drives_on", "required"),
    [
        (("bus", "base", "vision"), False, True),
        (("bus", "base", "vision"), True, False),
        (("vision",), True, True),  # on a computer of its own: nothing is left that could drive on
    ],
)
def test_vision_is_required_where_nothing_can_drive_on_without_it(processes, drives_on: bool, required: bool) -> None:
    config = configured(processes=processes, drive_without_vision=drives_on)
    assert children_of(config, Path("robot.toml"))[-1].required is required


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        ({"processes": ("bus", "bus")}, "processes"),
        ({"processes": ()}, "processes"),
        ({"processes": ("router",)}, "processes"),
        ({"first_pause_s": 3.0, "longest_pause_s": 2.0}, "longest_pause_s"),
        ({"base_silence_s": 0.0}, "base_silence_s"),
        ({"log_level": "loud"}, "log_level"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings: dict[str, object], name: str) -> None:
    with pytest.raises(RefusedError, match=f"^{name}: "):
        ServiceConfig(**settings)


def run_verb(config: Path) -> subprocess.CompletedProcess[str]:
    argv = [sys.executable, "-m", "edgefusion.cli", "run", "--config", str(config)]
    return subprocess.run(argv, capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("content", [None, "[service]\nprocesses = []\n"])
def test_a_configuration_that_will_not_do_is_refused_before_anything_is_started(
    tmp_path: Path, content: str | None
) -> None:
    config = tmp_path / "robot.toml"
    if content is not None:
        config.write_text(content)
    done = run_verb(config)
    assert (done.returncode, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 1 and str(config) in done.stderr
