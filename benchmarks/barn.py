# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How often, how fast and how safely the navigator gets through the worlds of BARN, in our simulator.

Both fields with a Jackal's footprint, accelerations and laser; then variants of the navigation function's drive at
1.0 m/s: a Pioneer 3-DX, wheels that go 2 % farther than they count, commands that take effect 0.2 s late (of that delay
the navigator is told, of the wheels' error it is not). Success: within the goal's tolerance, in truth; a contact is a
failure. Cylinders are polygons of 12 sides about them. The laser has 1 cm noise, no dropped beams, no mixed pixels, and
is 0.12 m ahead of the Jackal's middle, 0.10 m ahead of the Pioneer's axle.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, List, Sequence

from benchmarks.barn_setups import FIELDS, VARIANTS, Setup, setups
from benchmarks.barn_table import HEADER, cells, row
from benchmarks.barn_worlds import BarnWorld, Index, goal_in_odom, read_worlds, score
from benchmarks.nav_pictures import draw_run
from benchmarks.nav_run import Outcome, Run, drive, every
from benchmarks.run import markdown, write_results

from edgefusion.config import NavigationConfig
from edgefusion.errors import RefusedError
from edgefusion.navigation.navigator import Navigator
from edgefusion.sim.hull import Hull
from edgefusion.sim.plan_simulation import PlanSimulation
from edgefusion.tools.arguments import seed_number, whole_number
from edgefusion.types import Goal, Pose2D

EXAMPLES = """examples:
  python -m benchmarks.barn --worlds ../shared/data/barn/worlds.npz --index ../shared/data/barn/index.json
  python -m benchmarks.barn --worlds W.npz --index I.json --fields navigation-function --speeds 1.0 --limit 10
  python -m benchmarks.barn --worlds W.npz --index I.json --variants delay --only 12 30 --pictures"""

TOLERANCE_M = 0.3
"""Of the navigator's goal: less than the worlds', so that it drives into the disc that counts."""


@dataclass(frozen=True)
class Job:
    setup: Setup
    index: Index
    world: BarnWorld
    seed: int
    pictures: Path | None


def run_world(job: Job) -> Run:
    """One drive through one world."""
    index, setup, segments = job.index, job.setup, job.world.segments(job.index.radius)
    target = Pose2D(*index.goal)

    def there(sim: PlanSimulation) -> bool:
        return math.hypot(sim.pose.x_m - target.x_m, sim.pose.y_m - target.y_m) <= index.goal_tolerance

    sim = PlanSimulation(segments, Pose2D(*index.start), setup.spec, job.seed * 100_000 + job.world.number)
    navigator = Navigator(NavigationConfig(field=setup.field), setup.base)
    goal = Goal(str(job.world.number), goal_in_odom(index), TOLERANCE_M, math.pi)
    run = drive(sim, navigator, goal, index.timeout, there, at_once=True)
    if job.pictures and run.outcome is not Outcome.REACHED:
        name = f"{setup.field}-{setup.variant}-{setup.base.max_speed_mps:g}-{job.world.number}".replace(" ", "_")
        draw_run(job.pictures / f"{name}.png", name, segments, Hull(setup.spec.hull_m), target, run)
    return run


def world_record(world: BarnWorld, run: Run) -> dict[str, Any]:
    """One line of the per-world results."""
    points = score(run.outcome is Outcome.REACHED, world.path_length_m, run.time_s)
    return {"world": world.number, **run.record(), "score": round(points, 4)}


def chosen(worlds: List[BarnWorld], only: Sequence[int]) -> List[BarnWorld]:
    """Those of the numbers, or all where none is given. Raises RefusedError for a number that none of them has."""
    unknown = sorted(set(only) - {world.number for world in worlds})
    if unknown:
        raise RefusedError(f"--only: expected numbers of worlds in the index, got {', '.join(map(str, unknown))}")
    return [world for world in worlds if not only or world.number in only]


def main(argv: Sequence[str] | None = None) -> int:
    parser = _parser()
    args = parser.parse_args(argv)
    try:
        index, worlds = read_worlds(args.worlds, args.index)
        worlds = chosen(worlds, args.only)[: args.limit]
        driven = setups(index, args.fields, args.speeds, args.variants)
    except RefusedError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    rows, details = [], []
    for setup in driven:
        jobs = [Job(setup, index, world, args.seed, args.out / "barn" if args.pictures else None) for world in worlds]
        runs = every(
            run_world, jobs, args.processes, f"{setup.field}, {setup.base.max_speed_mps:g} m/s, {setup.variant}"
        )
        records = [world_record(world, run) for world, run in zip(worlds, runs)]
        rows.append(row(setup.field, setup.variant, setup.base, setup.spec, records))
        details.append({**rows[-1], "runs": records})
    conditions = f"20 Hz, goal within {index.goal_tolerance:g} m, {index.timeout:g} s at most, seed {args.seed}"
    table = f"{markdown(HEADER, [cells(each) for each in rows])}\n\n{conditions}"
    path = write_results(args.out, "barn", rows, table)
    (args.out / "barn_worlds.json").write_text(json.dumps(details, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(details) if args.json else table)
    print(f"written to {path}", file=sys.stderr)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.barn",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--worlds", type=Path, required=True, metavar="NPZ", help="cylinders: centres_<world> [n, 2]")
    parser.add_argument("--index", type=Path, required=True, metavar="JSON", help="start, goal, footprint, worlds")
    parser.add_argument("--fields", nargs="*", choices=FIELDS, default=FIELDS, help="default: both")
    parser.add_argument("--speeds", nargs="*", type=float, default=(1.0, 2.0), metavar="MPS", help="default: 1.0 2.0")
    parser.add_argument("--variants", nargs="*", choices=VARIANTS, default=VARIANTS, help="default: all")
    parser.add_argument("--limit", type=whole_number(1, 10**6), metavar="N", help="the first N worlds")
    parser.add_argument("--only", nargs="+", type=int, default=(), metavar="WORLD", help="worlds by their number")
    parser.add_argument("--seed", type=seed_number, default=0, help="of the laser's noise (default: 0)")
    parser.add_argument("--processes", type=whole_number(1, 512), default=os.cpu_count(), help="default: one a core")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), metavar="DIR", help="default: out/bench")
    parser.add_argument("--json", action="store_true", help="print the results of every world")
    parser.add_argument("--pictures", action="store_true", help="draw the drives that failed into DIR/barn")
    return parser


if __name__ == "__main__":
    sys.exit(main())
