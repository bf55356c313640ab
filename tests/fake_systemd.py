# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What systemd is to a service: a socket that hears it, and a program that it starts and ends."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Callable

TESTS = Path(__file__).parent
PATIENCE_S = 30.0


def child(name: str, what: str, *arguments: str, **fields: object) -> dict[str, object]:
    """The fields of a ChildSpec of one of small_child.py's."""
    argv = [sys.executable, str(TESTS / "small_child.py"), what, *arguments]
    return {"name": name, "argv": argv, "start_s": 60.0, "silence_s": 30.0, **fields}


class FakeSystemd:
    """Runs a small supervisor. heard: what it said."""

    def __init__(self, folder: Path, *children: dict[str, object], watchdog_s: float = 60.0) -> None:
        address = str(folder / "notify")
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(address)
        self._socket.settimeout(PATIENCE_S)
        self.heard: list[str] = []
        environment = {**os.environ, "NOTIFY_SOCKET": address, "WATCHDOG_USEC": str(round(watchdog_s * 1e6))}
        argv = [sys.executable, str(TESTS / "small_supervisor.py"), json.dumps(children), str(folder)]
        self.process = subprocess.Popen(argv, env=environment, stderr=subprocess.PIPE, text=True)

    def __enter__(self) -> FakeSystemd:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.end()
        self.process.stderr.close()
        self._socket.close()

    def hear(self) -> str:
        """The next that it says."""
        self.heard.append(self._socket.recv(65_536).decode())
        return self.heard[-1]

    def until(self, holds: Callable[[str], object]) -> str:
        """What it says, as soon as that holds."""
        deadline_s = time.monotonic() + PATIENCE_S
        while not holds(self.hear()):
            assert time.monotonic() < deadline_s, f"it said only {self.heard}"
        return self.heard[-1]

    def status(self, *parts: str) -> str:
        """The first status that has all that in it."""
        return self.until(lambda line: line.startswith("STATUS=") and all(part in line for part in parts))

    def ready(self) -> None:
        self.until(lambda line: line == "READY=1")

    def drain(self) -> list[str]:
        """What it said and was not heard yet."""
        lines = []
        self._socket.setblocking(False)
        try:
            while True:
                lines.append(self._socket.recv(65_536).decode())
        except BlockingIOError:
            self._socket.settimeout(PATIENCE_S)
        self.heard += lines
        return lines

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """Asks it to end: its exit code, and all that it told."""
        self.process.send_signal(number)
        return self.wait()

    def wait(self) -> tuple[int, str]:
        """The same, without asking."""
        try:
            _, told = self.process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        return self.process.returncode, told
