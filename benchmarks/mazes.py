# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How the navigator does where navigators fail: doorways, traps, dead ends, people, bad odometry, slow scans, no way.

A Pioneer 3-DX at 0.5 m/s, 0.3 m/s^2, 60 deg/s, 100 deg/s^2 with commands 0.05 s late and a laser of 361 beams over 180
degrees and 8.183 m, 0.10 m ahead of its axle: 1 cm noise, 1 % of beams dropped, mixed pixels at half of the edges. In
each family 20 worlds by seed; --check proves, without the navigator, that those that can be reached can be. Doorways 3
to 7 cm wider than the robot are tight: there arrivals are counted, and only contacts are faults.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, List, Sequence, Tuple

from benchmarks.maze_feasible import reachable
from benchmarks.maze_table import AIMS, HEADER, cells, is_right, missed, row
from benchmarks.maze_world import MazeWorld
from benchmarks.maze_worlds import FAMILIES, make
from benchmarks.nav_pictures import draw_run
from benchmarks.nav_run import Run, drive, every, plan_spec
from benchmarks.run import markdown, write_results

from edgefusion.config import BaseConfig, NavigationConfig
from edgefusion.navigation.navigator import Navigator
from edgefusion.sim.hull import Hull
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.plan_simulation import PlanSimulation, PlanSpec
from edgefusion.tools.arguments import seed_number, whole_number
from edgefusion.types import Goal

EXAMPLES = """examples:
  python -m benchmarks.mazes
  python -m benchmarks.mazes --families doorway spiral --limit 3 --pictures
  python -m benchmarks.mazes --families people --first 7 --limit 1 --json
  python -m benchmarks.mazes --first 1000    # 20 other worlds of each family
  python -m benchmarks.mazes --check

Exit codes: 0 as it should be, 1 an aim was missed."""

REACHED_LIMIT_S, BLOCKED_LIMIT_S = 180.0, 60.0
BASE = BaseConfig()
SCANS_500K = {"scan_period_ns": 26_666_666, "line_ns": 14_640_000}
SCANS_38400 = {"scan_period_ns": 200_000_000, "line_ns": 190_000_000}

World = Tuple[str, int]
"""Family and seed."""


@dataclass(frozen=True)
class Job:
    family: str
    seed: int
    pictures: Path | None


def spec_of(world: MazeWorld) -> PlanSpec:
    """The robot with what is wrong with it in this world."""
    pace = SCANS_38400 if world.slow_scans else SCANS_500K
    return plan_spec(BASE, LaserSpec(), slip_m=world.slip_m, jump_ns=round(world.jump_s * 1e9), jump=world.jump, **pace)


def run_world(job: Job) -> dict[str, Any]:
    """One drive, as a line of the per-world results."""
    world = make(job.family, job.seed)
    goal = Goal(world.name, world.goal.relative_to(world.start))

    def there(sim: PlanSimulation) -> bool:
        """It may roll on a little after it has arrived, not more."""
        off = goal.pose.relative_to(sim.odometry)
        near = math.hypot(off.x_m, off.y_m) <= 2 * goal.position_tolerance_m
        return near and abs(off.theta) <= 2 * goal.heading_tolerance

    sim = PlanSimulation(world.segments_at, world.start, spec_of(world), job.seed)
    limit_s = BLOCKED_LIMIT_S if world.reasons else REACHED_LIMIT_S
    run = drive(sim, Navigator(NavigationConfig(), BASE), goal, limit_s, there)
    right = is_right(world, run)
    if job.pictures and not right:
        _draw(job.pictures, world, run)
    expected = " or ".join(reason.value for reason in world.reasons) or ("reached" if world.demanded else "no contact")
    return {"world": world.name, "expected": expected, **run.record(), "right": right}


def _draw(folder: Path, world: MazeWorld, run: Run) -> None:
    segments = world.segments_at(round(run.time_s * 1e9))
    draw_run(folder / f"{world.name}.png", world.name, segments, Hull(BASE.footprint_m), world.goal, run)


def keeps_promise(name: World) -> bool:
    """Whether the goal can be reached exactly where the world says so; where it need not be nothing is promised."""
    world = make(*name)
    return not world.demanded or reachable(world.static, Hull(BASE.footprint_m), world.start, world.goal) is not bool(
        world.reasons
    )


def main(argv: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(argv)
    names = [(family, seed) for family in args.families for seed in range(args.first, args.first + args.limit)]
    return _check(names, args.processes) if args.check else _drive(names, args)


def _check(names: List[World], processes: int) -> int:
    kept = every(keeps_promise, names, processes, "worlds")
    for family, seed in (name for name, well in zip(names, kept) if not well):
        print(f"{family}-{seed}: not as promised")
    print(f"{sum(kept)} of {len(names)} worlds are as promised")
    return 0 if all(kept) else 1


def _drive(names: List[World], args: argparse.Namespace) -> int:
    pictures = args.out / "mazes" if args.pictures else None
    records = every(run_world, [Job(*name, pictures) for name in names], args.processes, "worlds")
    families = list(dict.fromkeys(family for family, _ in names))
    rows = [row(family, [r for r, name in zip(records, names) if name[0] == family]) for family in families]
    table = f"{markdown(HEADER, [cells(each) for each in rows])}\n\n{AIMS}\n{missed(records)}"
    path = write_results(args.out, "mazes", rows, table)
    (args.out / "mazes_worlds.json").write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(records) if args.json else table)
    print(f"written to {path}", file=sys.stderr)
    return 0 if all(record["right"] for record in records) else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.mazes",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    families = list(FAMILIES)
    parser.add_argument("--families", nargs="+", choices=families, default=families, metavar="FAMILY",
                        help=f"of {', '.join(families)}")  # fmt: skip
    parser.add_argument("--limit", type=whole_number(1, 10**6), default=20, metavar="N", help="worlds of each family")
    parser.add_argument("--first", type=seed_number, default=0, metavar="SEED", help="of the first world (default: 0)")
    parser.add_argument("--processes", type=whole_number(1, 512), default=os.cpu_count(), help="default: one a core")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), metavar="DIR", help="default: out/bench")
    parser.add_argument("--json", action="store_true", help="print the results of every world")
    parser.add_argument("--pictures", action="store_true", help="draw the drives that failed into DIR/mazes")
    parser.add_argument("--check", action="store_true", help="only check that the worlds are as promised")
    return parser


if __name__ == "__main__":
    sys.exit(main())
