# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated Pioneer on a pty, a supervisor whose base drives it, and what systemd hears and does, in real time."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Callable, Iterator, List, Tuple

import numpy as np

from edgefusion.drivers.sip_command import Command
from edgefusion.sim.floor_body import FloorBody
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.sim.wire_server import WireServer

Rng = np.random.Generator
PATIENCE_S, WATCHDOG_S = 30.0, 2.0
_PUMP_S = 0.001
_ZEROS = {(Command.STOP, None), (Command.E_STOP, None), (Command.VEL, 0)}


class SupervisorRig:
    """Its robot is there from entering to leaving. words: when systemd heard what."""

    def __init__(self, folder: Path) -> None:
        self._folder, self.body = folder, FloorBody()
        self.robot = SipRobot(self.body, now_ns=time.monotonic_ns())
        self._wire = PtyWire(folder / "robot")
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(folder / "notify"))
        self._socket.settimeout(_PUMP_S)
        self.words: List[Tuple[int, str]] = []
        self._end = threading.Event()
        self._threads = [threading.Thread(target=run, daemon=True) for run in (self._serve, self._hear)]

    def __enter__(self) -> SupervisorRig:
        for thread in self._threads:
            thread.start()
        self.start()
        self.wait(lambda: self.body.twist.v_mps > 0.29 and "vision ok" in self.status)
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(subprocess.TimeoutExpired):
            self.end()
        self.process.kill()
        self._end.set()
        for thread in self._threads:
            thread.join()
        self._socket.close()
        self._wire.close()

    def start(self) -> None:
        """The supervisor, as systemd does."""
        environment = {
            **os.environ,
            "NOTIFY_SOCKET": str(self._folder / "notify"),
            "WATCHDOG_USEC": str(round(WATCHDOG_S * 1e6)),
        }
        argv = [sys.executable, "-m", "benchmarks.supervised", "run", str(self._folder)]
        self.process = subprocess.Popen(argv, env=environment, stderr=subprocess.DEVNULL)

    def end(self) -> float:
        """How long that takes from SIGTERM on [s]."""
        begun_s = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(PATIENCE_S)
        return time.monotonic() - begun_s

    def kill(self, name: str, number: int = signal.SIGKILL) -> int:
        """A child. When that was [ns]."""
        os.kill(self.pid(name), number)
        return time.monotonic_ns()

    def pid(self, name: str) -> int:
        """Of a child that runs. Raises RuntimeError where none does."""
        parent = self.process.pid
        for pid in Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
            with suppress(OSError):
                if f"\0{name}\0".encode() in Path(f"/proc/{pid}/cmdline").read_bytes():
                    return int(pid)
        raise RuntimeError(f"no {name} runs")

    @property
    def status(self) -> str:
        """What systemd was told last of the children."""
        return next((word for _, word in reversed(self.words) if word.startswith("STATUS=")), "")

    def heard_ns(self, word: str, since_ns: int) -> int | None:
        """When systemd heard that first since then."""
        return next((ns for ns, heard in list(self.words) if ns >= since_ns and word in heard), None)

    def wait(self, done: Callable[[], object]) -> float:
        """How long until something is so [s]. Raises RuntimeError where it does not come to it."""
        begun_s = time.monotonic()
        while not done():
            if time.monotonic() - begun_s > PATIENCE_S:
                raise RuntimeError(f"it did not come to it: {self.status}")
            time.sleep(_PUMP_S)
        return time.monotonic() - begun_s

    def stopped_after_s(self, injected_ns: int) -> float:
        """T0: until the robot heard the first zero."""
        self.wait(lambda: self._first_zero_ns(injected_ns))
        return (self._first_zero_ns(injected_ns) - injected_ns) / 1e9

    def longest_gap_s(self, since_ns: int) -> float:
        """In what the robot heard."""
        heard_ns = [ns for ns, _ in list(self.robot.heard) if ns >= since_ns]
        return max((later - earlier for earlier, later in zip(heard_ns, heard_ns[1:])), default=0) / 1e9

    def _first_zero_ns(self, since_ns: int) -> int:
        heard = list(self.robot.heard)
        return next((ns for ns, told in heard if ns >= since_ns and (told.number, told.argument) in _ZEROS), 0)

    def _serve(self) -> None:
        server, last_ns = WireServer([(self.robot, (self._wire,))]), time.monotonic_ns()
        while not self._end.is_set():
            now_ns = time.monotonic_ns()
            self.body.base.step(now_ns - last_ns)
            server.pump(now_ns)
            last_ns = now_ns
            time.sleep(_PUMP_S)

    def _hear(self) -> None:
        while not self._end.is_set():
            with suppress(socket.timeout):
                word = self._socket.recv(65_536).decode()
                self.words.append((time.monotonic_ns(), word))


@contextmanager
def supervised(rng: Rng) -> Iterator[SupervisorRig]:
    """One whose robot has driven for a random while."""
    with tempfile.TemporaryDirectory() as folder, SupervisorRig(Path(folder)) as rig:
        time.sleep(rng.random())
        yield rig
