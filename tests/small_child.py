# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Children for a supervisor: `python small_child.py WHAT [ARGUMENT]`. Each is one function; none needs the C++ core."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

from edgefusion.service import notify, utc
from edgefusion.service.heartbeat import Heartbeat, from_environment

PAUSE_S = 0.02
STILL = "until it is told to end"


def well(beats: Heartbeat, says: str = STILL) -> None:
    """Beats until SIGTERM."""
    while True:
        beats.beat({"says": says})
        time.sleep(PAUSE_S)


def tells(beats: Heartbeat) -> None:
    """What it was given: the offset to UTC, whether it knows of systemd, whether it leads a session; and the others."""
    leads = os.getsid(0) == os.getpid()
    systemd = any(name in os.environ for name in notify.VARIABLES)
    nice, oom = os.nice(0), int(Path("/proc/self/oom_score_adj").read_text())
    while True:
        others = ",".join(f"{health.component}={health.state.value}" for health in beats.others())
        beats.beat({"says": f"{os.environ[utc.ENVIRONMENT]} {systemd} {leads} {nice} {oom} [{others}]"})
        time.sleep(PAUSE_S)


def crash(beats: Heartbeat) -> None:
    """Dies soon, of a signal."""
    beats.beat()
    os.kill(os.getpid(), signal.SIGSEGV)


def hang(beats: Heartbeat, pids: str) -> None:
    """Lives, but says nothing any more; has a child of its own, and writes down both."""
    own = subprocess.Popen(["sleep", "1000"])
    with Path(pids).open("a") as file:
        file.write(f"{os.getpid()} {own.pid}\n")
    beats.beat()  # its silence counts from here: when it is killed, both are written down
    time.sleep(1000)


def garbage(beats: Heartbeat) -> None:
    """Says what is no status, after it said one."""
    beats.beat({"says": "sense"})
    while True:
        for message in (b"\xff", b"[]", b"{", b"x" * 20_000):
            with suppress(BlockingIOError):
                beats._socket.send(message)
        time.sleep(PAUSE_S)


def drive(beats: Heartbeat, port: str, locks: str) -> None:
    """Drives a Pioneer, and stops it when it is told to end."""
    from edgefusion.config import BaseConfig, PioneerConfig
    from edgefusion.drivers.link import Link
    from edgefusion.drivers.pioneer import Pioneer
    from edgefusion.types import Twist2D

    link = Link(port, 9600, "small child", lock_folder=Path(locks))
    with Pioneer(link, PioneerConfig(), BaseConfig()) as robot:
        robot.start()
        while True:
            beats.beat({"port": port, "baudrate": link.baudrate, "says": "drives"})
            robot.drive(Twist2D(0.2))
            robot.poll()


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    globals()[sys.argv[1]](from_environment(), *sys.argv[2:])
