# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A laptop without the C++ core and ONNX Runtime: what its page promises works there."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

import pytest

from bus_base import Base, detection, report
from bus_lab import Lab
from edgefusion.bus import topics
from edgefusion.bus.requests import GotoRequest, StopRequest
from edgefusion.bus.topics import Topic
from edgefusion.messages import Message
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.from_mission import from_mission

PAGE = Path(__file__).resolve().parents[1] / "docs" / "laptop.md"
BARE = "import sys; sys.modules['edgefusion._core'] = sys.modules['onnxruntime'] = None\n"
"""Who imports either fails."""

MODULES = ("attending", "goto_drive", "goto_show", "mission_words", "teleop_loop", "topic_rates", "watch_loop")
VERBS = ("watch", "view", "goto", "stop", "resume", "teleop", "topics", "record", "recover", "keys")


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", BARE + code], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("viewer", [False, True])
def test_its_modules_need_neither_the_core_nor_the_runtime(viewer: bool) -> None:
    if viewer:
        pytest.importorskip("rerun")
    modules = (*MODULES, "view_feeds", "view_log", "view_sink") if viewer else MODULES
    done = run("".join(f"import edgefusion.tools.{module}\n" for module in modules))
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("verb", ["stop", "topics"])
def test_its_verbs_run_without_the_core(verb: str) -> None:
    with ExitStack() as stack:
        lab = Lab(stack)
        lab.router()
        base = Base(lab)
        done = run(f"from edgefusion.cli import main; sys.exit(main([{verb!r}, '--connect', {lab.tcp!r}]))")
        silent = "edgefusion: topics: nothing came of a robot named 'robot'; --robot names another\n"
        assert (done.returncode, done.stderr) == ((0, "") if verb == "stop" else (1, silent))
        assert base.asked == ([StopRequest()] if verb == "stop" else [])


def test_what_needs_the_core_says_so_in_one_line() -> None:
    done = run("from edgefusion.cli import main; sys.exit(main(['detect', 'drive', '--model', 'model']))")
    assert done.returncode == 2
    assert done.stderr == (
        "edgefusion: this verb needs the C++ core, which is not installed: `pip install .` in a clone compiles it\n"
    )


def test_the_page_names_its_verbs() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert [verb for verb in VERBS if verb not in page] == []


def test_the_page_s_example_runs_as_it_is() -> None:
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    ended = threading.Event()
    with ExitStack() as stack:
        lab = Lab(stack)
        lab.router()
        base = Base(lab)

        def talk(topic: Topic, message: Message) -> None:
            while not ended.wait(0.05):
                base.say(topic, message)

        said = {
            topics.MISSION: from_mission(report(2000, "arrived")),
            topics.DETECTIONS_DETAIL: from_detections_detail(7, [detection(7, 2.0)]),
        }  # each by a thread of its own: the first message of each waits until somebody listens
        talking = [threading.Thread(target=talk, args=each, daemon=True) for each in said.items()]
        for thread in talking:
            thread.start()
        done = run(example.replace("tls/robot.local:7447", lab.tcp))
        ended.set()
        for thread in talking:
            thread.join()
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[:2] == ["arrived None None", "oscilloscope 2.00 m at (2.0, 0.2)"]
    goto, stop = base.asked
    assert isinstance(goto, GotoRequest) and (goto.goals[0].x_m, goto.inspect) == (5, ("oscilloscope",))
    assert stop == StopRequest("found it")
