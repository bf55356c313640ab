# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What came of a soak: each kind of fault, each process, and whether all of it is as it should be."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence

from benchmarks.fault_row import ALLOWED
from benchmarks.run import markdown
from benchmarks.soak_health import Growth, Sample
from benchmarks.soak_run import Happened

GROWTH_MB, MORE = 5.0, 0
"""Aims: of memory, and of handles and threads."""

_MANY = 5
_WANTED = {"told": "told to stand in", "halted": "stands in", "heard": "hears commands every", "nothing": ""}


@dataclass(frozen=True)
class Result:
    """contacts: all of them. wrong: what ended though it should not have, or otherwise than it should. series: what the
    processes took, by name and id."""

    happened: Sequence[Happened]
    growths: Sequence[Growth]
    contacts: int
    wrong: Sequence[str]
    goals: Mapping[str, int]
    series: Mapping[str, Sequence[Sample]] = field(default_factory=dict)

    @property
    def unhelped(self) -> int:
        """Contacts of a robot that heard nothing."""
        return sum(each.unhelped for each in self.happened)

    @property
    def missed(self) -> List[Happened]:
        return [each for each in self.happened if each.missed]

    @property
    def grown(self) -> List[Growth]:
        return [each for each in self.growths if _grows(each, GROWTH_MB, MORE)]

    @property
    def broken(self) -> List[str]:
        """What no load of the machine explains."""
        found = list(self.wrong)
        if self.contacts > self.unhelped:
            found.append(f"expected no contact, got {self.contacts - self.unhelped}")
        for each in self.happened:
            if each.took_s is not None and each.took_s > ALLOWED * each.fault.limit_s:
                found.append(f"{each.fault.name} at {each.at_s:.0f} s: took {_shown(each.took_s)}")
            if math.isinf(each.again_s):
                found.append(f"{each.fault.name} at {each.at_s:.0f} s: the robot did not drive again")
        found += [_growth_line(each) for each in self.growths if _grows(each, ALLOWED * GROWTH_MB, _MANY)]
        return found

    @property
    def record(self) -> Dict[str, Any]:
        """For the JSON."""
        return {
            "contacts": self.contacts,
            "contacts_unhelped": self.unhelped,
            "wrong": list(self.wrong),
            "goals": dict(self.goals),
            "missed": len(self.missed),
            "faults": [_record(each) for each in self.happened],
            "processes": [_process(each) for each in self.growths],
            "series": {name: [list(each) for each in samples] for name, samples in self.series.items()},
        }


def _grows(growth: Growth, most_mb: float, more: int) -> bool:
    return growth.rss_mb > most_mb or growth.handles > more or growth.threads > more


def tracebacks(folder: Path) -> List[str]:
    """Logs in which Python tells of an exception that nobody expected."""
    found = []
    for log in sorted(folder.glob("*.log")):
        count = log.read_text(encoding="utf-8", errors="replace").count("Traceback (most recent call last)")
        found += [f"{log.name}: {count} tracebacks"] if count else []
    return found


def line_of(happened: Happened) -> str:
    """For whoever waits."""
    words = [f"{happened.at_s:6.0f} s  {happened.fault.name}: drives again in {_shown(happened.again_s)}"]
    if happened.took_s is not None:
        words.append(f"{_WANTED[happened.fault.wanted]} {_shown(happened.took_s)}")
    if happened.touched or happened.unhelped:
        words.append(f"{happened.touched} contacts, {happened.unhelped} while it heard nothing")
    return ", ".join(words) + (", MISSED" if happened.missed else "")


def tables(result: Result) -> str:
    """In Markdown."""
    rows = [_fault_row(name, each) for name, each in _by_name(result.happened).items()]
    header = ("fault", "times", "wanted", "median", "worst", "mended, until it drives again", "worst")
    grown = [_growth_row(each) for each in result.growths]
    processes = ("process", "judged", "RSS, first", "last", "grew", "handles", "threads", "")
    goals = ", ".join(f"{count} {name}" for name, count in sorted(result.goals.items()))
    said = [
        f"- faults: {len(result.happened)}; stop budgets missed: {len(result.missed)}; contacts: "
        f"{result.contacts - result.unhelped}, and {result.unhelped} while the robot heard nothing at all",
        f"- ended by themselves or not as they should: {'; '.join(result.wrong) or 'none'}",
        f"- what the operator heard: {goals}",
    ]
    return "\n\n".join([markdown(header, rows), markdown(processes, grown), "\n".join(said)])


def _by_name(happened: Sequence[Happened]) -> Dict[str, List[Happened]]:
    found: Dict[str, List[Happened]] = {}
    for each in happened:
        found.setdefault(each.fault.name, []).append(each)
    return dict(sorted(found.items()))


def _fault_row(name: str, happened: Sequence[Happened]) -> List[str]:
    fault = happened[0].fault
    times = [each.took_s for each in happened if each.took_s is not None]
    again = [each.again_s for each in happened]
    wanted = f"{_WANTED[fault.wanted]} {_shown(fault.limit_s)}" if fault.limit_s else "touches nothing"
    took = [_shown(statistics.median(times)), _shown(max(times))] if times else ["", ""]
    return [name, str(len(happened)), wanted, *took, _shown(statistics.median(again)), _shown(max(again))]


def _growth_row(growth: Growth) -> List[str]:
    if not growth.judged_s:
        return [growth.name, "", "", f"{growth.last.rss_mb:.1f} MB", "", "", "", "lived too short"]
    word = "grows" if _grows(growth, GROWTH_MB, MORE) else "met"
    return [
        growth.name,
        f"{growth.judged_s / 60:.1f} min",
        f"{growth.first.rss_mb:.1f} MB",
        f"{growth.last.rss_mb:.1f} MB",
        f"{growth.rss_mb:+.1f} MB",
        f"{growth.first.handles} {growth.handles:+d}",
        f"{growth.first.threads} {growth.threads:+d}",
        word,
    ]


def _growth_line(growth: Growth) -> str:
    more = f"{growth.rss_mb:+.1f} MB, {growth.handles:+d} handles, {growth.threads:+d} threads"
    return f"{growth.name}: grew by {more} in {growth.judged_s / 60:.1f} min"


def _record(happened: Happened) -> Dict[str, Any]:
    times = {"took_s": happened.took_s, "again_s": happened.again_s}
    finite = {name: None if value is None or math.isinf(value) else value for name, value in times.items()}
    return {
        "name": happened.fault.name,
        "at_s": happened.at_s,
        "limit_s": happened.fault.limit_s,
        **finite,
        "missed": happened.missed,
        "contacts": happened.touched,
    }


def _process(growth: Growth) -> Dict[str, Any]:
    first, last = growth.first._asdict(), growth.last._asdict()
    return {"name": growth.name, "judged_s": growth.judged_s, "first": first, "last": last}


def _shown(seconds: float) -> str:
    if math.isinf(seconds):
        return "never"
    return f"{1e3 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.1f} s"
