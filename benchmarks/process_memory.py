# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How much memory each process of a robot takes, and how much processor time it has had, by /proc."""

from __future__ import annotations

import os
import threading
from contextlib import suppress
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple

NAMES = ("bus", "base", "vision")
CAMERA = "vision's camera"
_WATCH_S = 2.0
_CAPTURE = b"edgefusion.drivers.camera_capture"


class Memory(NamedTuple):
    """rss_mb: all that is resident. pss_mb: of what several share each has its part: these add up."""

    rss_mb: float
    pss_mb: float


def processes(supervisor: int) -> Dict[str, int]:
    """The process ids of a supervisor and of what it has started, by name."""
    found = {"supervisor": supervisor}
    for pid in _children(supervisor):
        words = _command(pid)
        name = next((name for name in NAMES if name.encode() in words), None)
        if name is not None:
            found[name] = pid
        for below in _children(pid):
            if _CAPTURE in _command(below):
                found[CAMERA] = below
    return found


def memory(supervisor: int) -> Dict[str, Memory]:
    """Of each that lives."""
    found = {}
    for name, pid in processes(supervisor).items():
        with suppress(OSError):
            found[name] = _memory(pid)
    return found


class MemoryWatch:
    """Looks at a supervisor's processes every two seconds, in a thread, from its making until end()."""

    def __init__(self, supervisor: int) -> None:
        self._supervisor, self._ending = supervisor, threading.Event()
        self._seen: List[Dict[str, Memory]] = []
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def end(self) -> Dict[str, Memory]:
        """The most that each had, by what is its own."""
        self._ending.set()
        self._thread.join()
        names = {name for seen in self._seen for name in seen}
        return {
            name: max((seen[name] for seen in self._seen if name in seen), key=lambda each: each.pss_mb)
            for name in names
        }

    def _watch(self) -> None:
        while not self._ending.wait(_WATCH_S):
            with suppress(OSError):
                self._seen.append(memory(self._supervisor))


def busy_s(pid: int) -> float:
    """The processor time that a process has had."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Spent(NamedTuple):
    """What all processors have done since the machine was started [s]."""

    busy_s: float
    all_s: float

    def busy_since(self, before: Spent) -> float:
        """The share of all processors' time that was used."""
        return (self.busy_s - before.busy_s) / max(self.all_s - before.all_s, 1e-9)


def spent_by_all() -> Spent:
    """Of the whole machine, whoever it was spent on. What another machine beside it has taken counts as used."""
    ticks = [int(each) for each in Path("/proc/stat").read_text(encoding="ascii").splitlines()[0].split()[1:9]]
    idle, second = ticks[3] + ticks[4], os.sysconf("SC_CLK_TCK")
    return Spent((sum(ticks) - idle) / second, sum(ticks) / second)


def _memory(pid: int) -> Memory:
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()[1:]
    kb = {name: int(rest.split()[0]) for name, _, rest in (line.partition(":") for line in lines)}
    return Memory(kb["Rss"] / 1024, kb["Pss"] / 1024)


def _children(pid: int) -> Iterator[int]:
    """Also those that one of its threads has started."""
    for task in Path(f"/proc/{pid}/task").iterdir():
        with suppress(OSError):
            yield from map(int, (task / "children").read_text(encoding="ascii").split())


def _command(pid: int) -> list[bytes]:
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    return []
