# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion demo`: a simulated robot drives to a goal, inspects what is of interest, and a report shows it all."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from edgefusion.errors import RefusedError
from edgefusion.tools.arguments import LAB_MODEL, seed_number, whole_number

if TYPE_CHECKING:
    from edgefusion.sim.world import World

EXAMPLES = """examples:
  edgefusion demo
  edgefusion demo --goal 5.2 0.9 -90 --seed 7
  edgefusion demo --world street --inspect car --out out/street
  edgefusion demo --world my_world.toml --model models/mine --json
  edgefusion demo --view

DIR gets index.html, which any browser opens, report.json with the same numbers, detections.jsonl, and what was
inspected. In the laboratory the seed also places the oscilloscope on the way; 0 leaves it where the world has it.
Exit codes: 0 done, 1 failed while running, 2 refused input, 130 interrupted; what was written before stays. A robot
that did not arrive has failed."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "demo",
        help="see it work without a robot",
        description="Drives a simulated robot to a goal in a world, stops for a picture of every object of interest, "
        "and writes a report about it.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--world", default="laboratory", help="laboratory, office, street, storeroom, or a TOML file")
    add("--goal", type=float, nargs=3, metavar=("X", "Y", "DEG"), help="in the world's frame (default: the world's)")
    interest = parser.add_mutually_exclusive_group()
    interest.add_argument(
        "--inspect",
        action="append",
        default=[],
        metavar="LABEL",
        help="a label or group to stop for; repeatable (default: oscilloscope in the laboratory, else none)",
    )
    interest.add_argument("--no-inspect", action="store_true", help="stop for nothing")
    add("--out", type=Path, metavar="DIR", help="folder for the report (default: out/demo)")
    add("--overwrite", action="store_true", help="replace the report in DIR")
    add("--model", type=Path, default=LAB_MODEL, help="model folder (default: the simulator's own)")
    add("--seed", type=seed_number, default=0, metavar="N", help="of light, noise, slip and place (default: 0)")
    add("--view", action="store_true", help="show it live in a browser on this machine, in real time")
    add("--port", type=whole_number(0, 2**16 - 1), metavar="N", help="of the live view (default: a free one)")
    add("--json", action="store_true", help="print the numbers as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Drives, detects, writes the report; 1 where the robot did not arrive. Raises RefusedError."""
    import shlex
    import sys

    import msgspec

    from edgefusion.tools.demo_run import DemoOptions, run_demo
    from edgefusion.tools.report_plots import check_matplotlib
    from edgefusion.tools.results import results_path

    if args.port is not None and not args.view:
        raise RefusedError(f"--port {args.port}: expected --view beside it")
    check_matplotlib()
    options = DemoOptions(
        world=_world(args),
        out=results_path(args.out, "demo", args.overwrite),
        overwrite=args.overwrite,
        model=args.model,
        seed=args.seed,
        interest=_interest(args),
        port=(args.port or 0) if args.view else None,
        command=shlex.join(["edgefusion", *sys.argv[1:]]),
    )
    report = run_demo(options)
    print(msgspec.json.encode(report).decode() if args.json else _as_text(report, options.out))
    return 0 if report["drive"]["arrived"] else 1


def _world(args: argparse.Namespace) -> World:
    """As it ships, but for what the seed and the options say."""
    from edgefusion.sim.world_file import load_world
    from edgefusion.tools.experiment import LABORATORY, placed_by_seed
    from edgefusion.types import Pose2D

    world = load_world(args.world)
    if args.world == LABORATORY:
        world = placed_by_seed(world, args.seed)
    if args.goal is None:
        return world
    x_m, y_m, degrees = args.goal
    if not all(abs(value) < 1000 for value in args.goal):  # also of nan
        raise RefusedError(f"--goal {x_m:g} {y_m:g} {degrees:g}: expected metres and degrees below 1000")
    return replace(world, goal=Pose2D(x_m, y_m, math.radians(degrees)))


def _interest(args: argparse.Namespace) -> tuple[str, ...]:
    from edgefusion.config import MissionConfig
    from edgefusion.tools.experiment import LABORATORY

    if args.inspect or args.no_inspect:
        return tuple(args.inspect)
    return MissionConfig().interest if args.world == LABORATORY else ()


def _as_text(report: dict[str, Any], out: Path) -> str:
    drive, objects, error = report["drive"], report["objects"], report["distance_error_mm"]
    median = "none measured" if error["median"] is None else f"{error['median']:.0f} mm"
    clearance = "nothing near" if drive["clearance_m"] is None else f"{drive['clearance_m']:.2f} m"
    off = f"{100 * drive['odometry_error_m']:.1f} cm, {drive['odometry_error_deg']:.1f} degrees"
    return "\n".join(
        [
            f"{drive['outcome'] + ':':<17}{drive['reason'] or off + ' off its goal, by its odometry'}",
            *(f"inspected:       {_as_line(row)}" for row in report["mission"]["inspections"]),
            f"drive:           {drive['way_m']:.1f} m in {drive['duration_s']:.1f} s, {report['frames']} frames, "
            f"clearance {clearance}",
            f"found:           {objects['found']} of {objects['in_view']} objects, {objects['named']} named right",
            f"distance error:  {median} (median)",
            f"took:            {report['took_s']:.1f} s",
            f"report:          {out / 'index.html'}",
        ]
    )


def _as_line(row: dict[str, Any]) -> str:
    where = f"{row['label']} at ({row['place_m'][0]:.2f}, {row['place_m'][1]:.2f})"
    return f"{where}, {row['picture'] or 'no picture: ' + row['reason']}"
