# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One child as a process: how it is started, heard, told and killed."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence

import msgspec

from edgefusion.service import heap, heartbeat
from edgefusion.service.child_spec import ChildSpec
from edgefusion.types import Health

_PENDING = 256
"""More beats than these are not read at once."""


class ChildProcess:
    """Started when it is made; raises OSError where its command cannot be run. fileno(): readable when it spoke, and
    for ever once it hung_up: it is about to end, or silent from then on.

    It leads a session of its own: Ctrl-C in a terminal is the supervisor's matter alone, and what it has started itself
    can be killed with it.
    """

    def __init__(self, spec: ChildSpec, environment: Mapping[str, str]) -> None:
        self.name, self.hung_up = spec.name, False
        self._line, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._line.setblocking(False)
        with theirs:
            try:
                self._process = _popen(spec, theirs.fileno(), environment)
            except BaseException:
                self._line.close()
                raise
        _yield_to_others(self._process.pid, spec)

    def fileno(self) -> int:
        return self._line.fileno()

    @property
    def pid(self) -> int:
        return self._process.pid

    def beats(self) -> Sequence[Dict[str, Any]]:
        """What it said since the last time, where that is a status."""
        statuses: List[Dict[str, Any]] = []
        for _ in range(_PENDING):
            try:
                message = self._line.recv(heartbeat.MAX_BYTES + 1)
            except BlockingIOError:
                break
            except OSError:
                message = b""
            if not message:
                self.hung_up = True
                break
            with suppress(msgspec.MsgspecError):
                statuses.append(msgspec.json.decode(message, type=Dict[str, Any]))
        return statuses

    def tell(self, healths: Sequence[Health]) -> None:
        """How the others are. Lost where it does not listen."""
        with suppress(OSError):
            self._line.send(msgspec.json.encode(healths))

    def send(self, number: int) -> None:
        """A signal; SIGKILL also goes to all that it has started."""
        with suppress(ProcessLookupError):
            (os.killpg if number == signal.SIGKILL else os.kill)(self._process.pid, number)

    def poll(self) -> int | None:
        """Its exit code once it is gone, negative for a signal; what it has started and left behind is killed then."""
        if self._process.returncode is None:
            # Before it is reaped: until then nobody else gets its number.
            if os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
                return None
            self.send(signal.SIGKILL)
        return self._process.poll()

    def close(self) -> None:
        """The line. To a child that still runs it means that its supervisor is gone."""
        self._line.close()


def _popen(spec: ChildSpec, line: int, environment: Mapping[str, str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        spec.argv,
        stdin=subprocess.DEVNULL,
        env={**heap.ENVIRONMENT, **environment, heartbeat.ENVIRONMENT: str(line)},
        pass_fds=[line],
        start_new_session=True,
    )


def _yield_to_others(pid: int, spec: ChildSpec) -> None:
    """Without privileges a process can only be made to yield more. One that died at once needs not."""
    with suppress(OSError):
        if spec.nice:
            os.setpriority(os.PRIO_PROCESS, pid, os.getpriority(os.PRIO_PROCESS, 0) + spec.nice)
        if spec.oom_score_adj:
            Path(f"/proc/{pid}/oom_score_adj").write_text(str(spec.oom_score_adj))
