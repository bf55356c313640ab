# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A router with keys, in a process of its own, and others beside it that can be killed or halted."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
import time
from datetime import datetime
from pathlib import Path
from typing import Callable, List

import zenoh

from edgefusion.bus import key_folder
from edgefusion.bus.session import UnreachableError, open_client

PATIENCE_S = 30.0


def resident_bytes(process: int | str = "self") -> int:
    """What it takes of the memory: a process id, or this one."""
    pages = int(Path(f"/proc/{process}/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def wait_for(condition: Callable[[], object]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > end_s:
            raise UnreachableError(f"expected it within {PATIENCE_S:g} s")
        time.sleep(0.002)


class BusRig:
    """From entering to leaving; all processes are killed at the end."""

    def __init__(self, max_command_hz: float = 50.0) -> None:
        self._max_command_hz = max_command_hz
        self._folder = tempfile.TemporaryDirectory()
        self.keys = Path(self._folder.name)
        self.tcp, self.tls = f"tcp/127.0.0.1:{free_port()}", f"tls/localhost:{free_port()}"
        self._processes: List[subprocess.Popen[str]] = []
        self._sessions: List[zenoh.Session] = []

    def __enter__(self) -> BusRig:
        key_folder.init(self.keys, ["robot"], datetime(2040, 1, 1))
        self.router = self.start_router()
        return self

    def __exit__(self, *_: object) -> None:
        for session in self._sessions:
            session.close()  # type: ignore[no-untyped-call]
        for process in self._processes:
            process.kill()
            process.wait()
        self._folder.cleanup()

    def start_router(self) -> subprocess.Popen[str]:
        return self.play("router", f"{self.tcp},{self.tls}", str(self.keys / "robot"), str(self._max_command_hz))

    def member(self) -> zenoh.Session:
        """One of the robot's own processes: this one."""
        session = open_client(self.tcp)
        self._sessions.append(session)
        return session

    def join(self, player: str, role: str, *arguments: object) -> subprocess.Popen[str]:
        """A process that joins with the keys of a role; it is there when this returns."""
        return self.play(player, self.tls, str(self.keys / role), *map(str, arguments))

    def play(self, *arguments: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "benchmarks.bus_players", *arguments]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self._processes.append(process)
        assert process.stdout is not None
        if process.stdout.readline() != "ready\n":
            raise UnreachableError(f"{arguments[0]}: did not come up")
        return process


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port: int = taken.getsockname()[1]
        return port
