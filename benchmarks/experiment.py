# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's experiment, many times: as `edgefusion demo` drives it, but for the report's pictures.

From (0, 0) to [5 m, 5.5 m, 15 degrees] in the laboratory; the oscilloscope stands where the seed places it, near the
straight way, and light, noise and slip follow the seed, too. A picture counts where the detector found that very
oscilloscope in it; clearances are the hull's, at the laser's height. The robot knows its odometry alone: how far it
really is from its goal is what the wheels slipped, beside the odometry's error.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple, Sequence

from benchmarks.nav_run import every
from benchmarks.run import markdown, write_results

from edgefusion.config import MissionConfig
from edgefusion.errors import RefusedError
from edgefusion.sim.built_world import build
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.world_file import load_world
from edgefusion.tools.arguments import LAB_MODEL, seed_number, whole_number
from edgefusion.tools.demo_robot import demo_robot
from edgefusion.tools.demo_run import as_fast_as_it_can
from edgefusion.tools.drive_report import drive_figures
from edgefusion.tools.experiment import LABORATORY, ON_THE_WAY, placed_by_seed

EXAMPLES = """examples:
  python -m benchmarks.experiment --seeds 20
  python -m benchmarks.experiment --seeds 1 --first 7 --json"""

HEADER = (
    "drives",
    "arrived",
    "pictures of it",
    "others",
    "contacts",
    "off the goal by odometry, median / worst",
    "in truth, median / worst",
    "time, median / worst",
    "clearance, median / least",
)


class Job(NamedTuple):
    seed: int
    model: Path


def run_seed(job: Job) -> dict[str, Any]:
    """One drive: report.json's figures of it, and what was inspected. pictures: of the object that the experiment is
    about; others: inspections of anything else, and those without a picture of it."""
    robot = demo_robot(job.model, MissionConfig().interest)
    with Renderer(robot.rig) as renderer:
        world = build(placed_by_seed(load_world(LABORATORY), job.seed), robot.rig.laser_height_m)
        drive = robot.drive(world, renderer, job.seed, as_fast_as_it_can)
        frames = sum(1 for _ in drive)
    results = drive.log.inspections
    pictures = sum(drive.pictured.get(result.id) == ON_THE_WAY for result in results)
    return {
        "seed": job.seed,
        **drive_figures(drive, world.world.goal),
        "frames": frames,
        "pictures": pictures,
        "others": len(results) - pictures,
        "notes": [result.note or result.reason for result in results if result.note or result.reason],
    }


def summary(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The row of the table; end poses and times are of those that arrived."""
    there = [run for run in runs if run["arrived"]]
    row = {
        "drives": len(runs),
        "arrived": len(there),
        "pictures": sum(run["pictures"] == 1 for run in runs),
        "others": sum(run["others"] for run in runs),
        "contacts": sum(run["clearance_m"] == 0 for run in runs),
        "clearance_m": _spread(runs, "clearance_m", min),
    }
    names = ("odometry_error_m", "odometry_error_deg", "true_error_m", "true_error_deg", "duration_s")
    return {**row, **{name: _spread(there, name, max) for name in names}}


def _spread(runs: Sequence[dict[str, Any]], name: str, worst: Any) -> tuple[float, float] | None:
    """Median and worst; None of no runs."""
    values = [run[name] for run in runs]
    return (median(values), worst(values)) if values else None


def cells(row: dict[str, Any]) -> list[str]:
    """A row as text."""
    return [
        *(str(row[name]) for name in ("drives", "arrived", "pictures", "others", "contacts")),
        f"{_pair(row['odometry_error_m'], 100, '{:.1f} / {:.1f} cm')}, {_pair(row['odometry_error_deg'], 1)} deg",
        f"{_pair(row['true_error_m'], 100, '{:.1f} / {:.1f} cm')}, {_pair(row['true_error_deg'], 1)} deg",
        f"{_pair(row['duration_s'], 1)} s",
        f"{_pair(row['clearance_m'], 100, '{:.0f} / {:.0f} cm')}",
    ]


def _pair(values: tuple[float, float] | None, scale: float, form: str = "{:.1f} / {:.1f}") -> str:
    return "-" if values is None else form.format(*(scale * value for value in values))


def main(argv: Sequence[str] | None = None) -> int:
    parser = _parser()
    args = parser.parse_args(argv)
    jobs = [Job(args.first + i, args.model) for i in range(args.seeds)]
    try:
        runs = every(run_seed, jobs, args.processes, "experiment")
    except RefusedError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    row = summary(runs)
    table = markdown(HEADER, [cells(row)])
    path = write_results(args.out, "experiment", [row, *runs], table)
    print(json.dumps(runs) if args.json else table)
    for run in runs:
        if not (run["arrived"] and run["pictures"] == 1 and run["others"] == 0):
            print(f"seed {run['seed']}: {run['outcome']} {run['reason']}, {run['notes']}", file=sys.stderr)
    print(f"written to {path}", file=sys.stderr)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.experiment",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=whole_number(1, 10**4), default=20, metavar="N", help="drives (default: 20)")
    parser.add_argument("--first", type=seed_number, default=0, metavar="SEED", help="the first seed (default: 0)")
    parser.add_argument("--model", type=Path, default=LAB_MODEL, help="model folder (default: the simulator's own)")
    parser.add_argument("--processes", type=whole_number(1, 512), default=os.cpu_count(), help="default: one a core")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), metavar="DIR", help="default: out/bench")
    parser.add_argument("--json", action="store_true", help="print the results of every drive")
    return parser


if __name__ == "__main__":
    sys.exit(main())
