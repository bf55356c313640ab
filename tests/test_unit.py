# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The service's unit: systemd understands it, it gives away little, and it fits what the program does."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from edgefusion.service.child_watch import REFUSED
from edgefusion.service.real_time import PRIORITY, RealTime, run_in_real_time, scheduling
from edgefusion.service.supervision import END_NS
from edgefusion.service.supervisor import TURN_S

UNIT = Path(__file__).resolve().parents[1] / "deploy" / "jetson" / "edgefusion.service"
EXPOSURE = 2.5


def settings() -> dict[str, str]:
    lines = [line for line in UNIT.read_text().splitlines() if "=" in line and not line.startswith("#")]
    return dict(line.split("=", 1) for line in lines)


@pytest.fixture
def analyze(tmp_path: Path):
    """Runs systemd-analyze on the unit, whose program is one that is here."""
    if shutil.which("systemd-analyze") is None:
        pytest.skip("no systemd-analyze on this machine")
    unit = tmp_path / UNIT.name
    unit.write_text(re.sub(r"^ExecStart=\S+", "ExecStart=/bin/true", UNIT.read_text(), flags=re.MULTILINE))

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(["systemd-analyze", *arguments, str(unit)], capture_output=True, text=True)

    return run


def test_systemd_understands_every_line(analyze) -> None:
    done = analyze("verify", "--man=no", "--recursive-errors=no")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_it_is_exposed_as_little_as_it_may_be(analyze) -> None:
    done = analyze("security", "--offline=true", f"--threshold={round(10 * EXPOSURE)}", "--no-pager")
    assert done.returncode == 0, done.stdout[-200:]


def test_its_times_fit_the_program() -> None:
    found = settings()
    assert float(found["TimeoutStopSec"]) * 1e9 > END_NS
    assert float(found["WatchdogSec"]) > 10 * TURN_S
    assert found["RestartPreventExitStatus"] == str(REFUSED)
    assert int(found["LimitRTPRIO"]) >= PRIORITY


@pytest.mark.parametrize("name", ["PrivateTmp", "PrivateDevices", "PrivateUsers", "DeviceAllow", "RestrictRealtime"])
def test_it_hides_nothing_that_the_program_needs(name: str) -> None:
    assert name not in settings()


def test_real_time_is_for_the_thread_that_asked_where_it_may() -> None:
    found = []

    def ask() -> None:
        had = run_in_real_time()
        found.append((had, os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO))

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    assert found[0] in [(True, True), (False, False)]
    assert os.sched_getscheduler(0) != os.SCHED_FIFO


def test_without_leave_there_is_no_real_time_and_no_error() -> None:
    code = (
        "import os, resource; from edgefusion.service.real_time import RealTime, run_in_real_time, scheduling; "
        "resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0)); os.getuid() or os.setuid(65534); os.nice(3); "
        "asked = RealTime(); asked(); asked(); print(run_in_real_time(), scheduling(), asked, sep='; ')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    answer, shared, asked = done.stdout.strip().split("; ")
    assert (answer, shared.split()[:2], asked) == ("False", ["shared,", "nice"], "0 of 2 threads")
    assert done.stderr.count("real time: not allowed (LimitRTPRIO in its unit)") == 1


def test_whether_threads_have_real_time_is_told_as_it_is(caplog: pytest.LogCaptureFixture) -> None:
    """Here it may be allowed or not; what is said is what the kernel says."""
    asked, found = RealTime(), []

    def drive() -> None:
        asked()
        found.append(scheduling())

    with caplog.at_level("INFO"):
        for _ in range(2):
            thread = threading.Thread(target=drive)
            thread.start()
            thread.join()
    has = found[0] == f"real time, priority {PRIORITY}"
    assert str(asked) == f"{2 * has} of 2 threads"
    assert [record.levelname for record in caplog.records] == ["INFO" if has else "WARNING"]
