# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The table of the drives through mazes, by family, and what was aimed at."""

from __future__ import annotations

import math
from statistics import median
from typing import Any, Mapping, Sequence

from benchmarks.maze_world import MazeWorld
from benchmarks.nav_run import Outcome, Run

Record = Mapping[str, Any]

HEADER = (
    "family",
    "worlds",
    "reached",
    "blocked, right reason",
    "contacts",
    "walked into",
    "as it should be",
    "median time",
    "least clearance",
)
AIMS = (
    "aims: every goal reached that can be; where it cannot, blocked with the right reason within 60 s; no contacts "
    "(walked into: by a person, while the robot had stood for 0.3 s); tight doorways as far as it goes: no contacts"
)


def is_right(world: MazeWorld, run: Run) -> bool:
    """Whether a drive ended as it should. A person who walks into a standing robot is not the robot's fault."""
    if not world.demanded:
        return run.outcome not in (Outcome.CONTACT, Outcome.ELSEWHERE)
    if world.reasons:
        return run.outcome is Outcome.BLOCKED and run.reason in {reason.value for reason in world.reasons}
    return run.outcome is Outcome.REACHED or (bool(world.people) and run.outcome is Outcome.WALKED_INTO)


def row(family: str, runs: Sequence[Record]) -> dict[str, Any]:
    """The figures of a family; the time is that of the drives that ended as expected, NaN where none did."""

    def count(outcome: Outcome) -> int:
        return sum(run["outcome"] == outcome.value for run in runs)

    right = [run for run in runs if run["right"]]
    blocked = [run for run in right if run["outcome"] == Outcome.BLOCKED.value and run["reason"] in run["expected"]]
    there = [run for run in right if run["outcome"] in (Outcome.REACHED.value, Outcome.WALKED_INTO.value)]
    return {
        "family": family,
        "worlds": len(runs),
        "reached": count(Outcome.REACHED),
        "blocked_right": len(blocked),
        "contacts": count(Outcome.CONTACT),
        "walked_into": count(Outcome.WALKED_INTO),
        "right": len(right),
        "time_median_s": median([run["time_s"] for run in [*there, *blocked]] or [math.nan]),
        "clearance_least_m": min(run["clearance_m"] for run in runs),
    }


def cells(row: Record) -> list[str]:
    """A row as text."""
    counts = ("worlds", "reached", "blocked_right", "contacts", "walked_into", "right")
    return [
        row["family"],
        *(str(row[name]) for name in counts),
        f"{row['time_median_s']:.1f} s" if math.isfinite(row["time_median_s"]) else "-",
        f"{1000 * row['clearance_least_m']:.0f} mm",
    ]


def missed(runs: Sequence[Record]) -> str:
    """The drives that did not end as they should, in one line each."""
    wrong = [
        f"{run['world']}: {run['outcome']}{run['reason'] and ', '}{run['reason']} after {run['time_s']:g} s, "
        f"expected {run['expected']}"
        for run in runs
        if not run["right"]
    ]
    return "\n".join(["met" if not wrong else f"missed in {len(wrong)} of {len(runs)} worlds:", *wrong])
