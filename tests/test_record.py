# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion record` and `edgefusion recover` as a user runs them, on a real bus."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Callable, Iterator

import pytest

from bus_lab import Lab, until
from edgefusion.bus import session
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.session import UnreachableError
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import MISSION, SCAN
from edgefusion.cli import build_parser, main
from edgefusion.messages.cdr import decode
from edgefusion.messages.sensor_msgs import LaserScan
from edgefusion.messages.std_msgs import String
from edgefusion.recording.mcap_bag import McapBag
from edgefusion.recording.mcap_survey import survey
from mcap_scenes import written


class Robot:
    """Tells its mission and its scans, each with a number."""

    def __init__(self, lab: Lab) -> None:
        session, tagger = lab.router(), Tagger("base")
        self._mission = Publisher(session, "robot", MISSION, tagger, "boot")
        self._scan = Publisher(session, "robot", SCAN, tagger, "boot")
        self.told = 0

    def tell(self) -> None:
        self._mission.put(String(str(self.told)), self.told)
        self._scan.put(LaserScan(ranges=[float(self.told)]), self.told)
        self.told += 1

    def has_listeners(self) -> bool:
        return self._mission.wanted(0) and self._scan.wanted(0)


@pytest.fixture
def lab() -> Iterator[Lab]:
    with ExitStack() as stack:
        yield Lab(stack)


@contextmanager
def recording(lab: Lab, path: Path, *more: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "edgefusion.cli", "record", str(path), "--connect", lab.tcp, *more]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def messages_in(path: Path) -> int:
    if not path.exists() or not path.stat().st_size:
        return 0
    with path.open("rb") as file:
        return sum(survey(file).index.messages.values())


def numbers(path: Path, topic: str) -> list[int]:
    read = McapBag(path).read({topic})
    if topic == "/scan":
        return [int(decode(LaserScan, message.data).ranges[0]) for message in read]
    return [int(decode(String, message.data).data) for message in read]


def has_told_until(robot: Robot, condition: Callable[[], bool]) -> Callable[[], bool]:
    """Tells something every time it is asked."""

    def asked() -> bool:
        robot.tell()
        return condition()

    return asked


def test_what_is_on_the_bus_is_in_the_file_when_the_recording_is_ended(lab: Lab, tmp_path: Path) -> None:
    robot, path = Robot(lab), tmp_path / "a.mcap"
    with recording(lab, path) as process:
        until(robot.has_listeners, 30)
        until(has_told_until(robot, lambda: messages_in(path) >= 100), 30)
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (0, "")
    missions, scans = numbers(path, "/mission"), numbers(path, "/scan")
    assert f"{path}: {len(missions) + len(scans)} messages of 2 topics, " in out
    for found in (missions, scans):  # a full line drops what it cannot take
        assert 40 < len(found) <= robot.told and found == sorted(set(found)) and found[-1] < robot.told
    assert main(["recover", str(path)]) == 0


def test_killed_it_leaves_what_it_had_and_recover_mends_it(
    lab: Lab, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot, path = Robot(lab), tmp_path / "a.mcap"
    with recording(lab, path, "--topic", "/mission") as process:
        until(lambda: robot._mission.wanted(0), 30)
        until(has_told_until(robot, lambda: path.exists() and path.stat().st_size > 5_000), 30)
        process.kill()
    assert main(["recover", str(path)]) == 0
    kept = numbers(path, "/mission")
    assert kept == sorted(set(kept)) and 20 < len(kept) <= robot.told
    assert McapBag(path).topics[0].name == "/mission" and len(McapBag(path).topics) == 1
    assert capsys.readouterr().out.startswith(f"{path}: mended, {len(kept)} messages of ")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["a.mcap"], "a.mcap: exists already; --overwrite replaces it"),
        (["a.mcap", "--overwrite", "--reserve", "1000000"], r"a.mcap: cannot write there: \d+ MB are free on the disk"),
        (["nowhere/b.mcap"], "nowhere/b.mcap: cannot write there: No such file or directory"),
        (["b.mcap", "--topic", "camera"], "--topic: expected some of scan, odom, .*, got camera"),
        (["b.mcap", "--reserve", "1000000"], r"b.mcap: cannot write there: \d+ MB are free on the disk, 1000000 MB"),
        (["b.mcap", "--connect", "tcp/192.0.2.1:7447"], "connect: .*expected tcp on loopback only|endpoint: expected"),
    ],
)
def test_what_cannot_be_recorded_is_refused(
    lab: Lab,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    named: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    written(Path("a.mcap"))
    before = Path("a.mcap").read_bytes()
    lab.router()
    assert main(["record", "--connect", lab.tcp, *arguments]) == 2
    assert re.search(named, capsys.readouterr().err)
    assert (Path("a.mcap").read_bytes(), Path("b.mcap").exists()) == (before, False)


def test_without_a_bus_nothing_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nobody(*_: object, **__: object) -> None:
        raise UnreachableError("nobody is there")

    monkeypatch.setattr(session, "open_client", nobody)
    args = build_parser().parse_args(["record", str(tmp_path / "a.mcap")])
    with pytest.raises(UnreachableError):
        args.run(args)
    assert not (tmp_path / "a.mcap").exists()


def test_recover_says_what_it_did(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.mcap"
    written(path)
    assert main(["recover", str(path)]) == 0
    path.write_bytes(path.read_bytes()[:-30])
    assert main(["recover", str(path)]) == 0
    assert capsys.readouterr().out.splitlines()[0] == f"{path}: whole, 12 messages of 0.1 s; nothing was to be done"
    assert main(["recover", str(tmp_path / "b.mcap")]) == 2


def test_a_bus_that_goes_away_does_not_end_it_and_it_goes_on_when_the_bus_is_back(lab: Lab, tmp_path: Path) -> None:
    router, path = lab.router(), tmp_path / "a.mcap"
    with recording(lab, path, "--topic", "mission") as process:
        until(lambda: path.exists(), 30)
        router.close()
        robot = Robot(lab)
        until(lambda: robot._mission.wanted(0), 30)
        until(has_told_until(robot, lambda: messages_in(path)), 30)
        assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 0
