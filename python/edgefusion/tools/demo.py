# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion demo`: drives a simulated robot through a world and shows what the detector makes of it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from edgefusion.errors import RefusedError
from edgefusion.tools.arguments import LAB_MODEL, seed_number, whole_number

EXAMPLES = """examples:
  edgefusion demo
  edgefusion demo --world street --seed 3 --out out/street
  edgefusion demo --world my_world.toml --model models/mine --json
  edgefusion demo --view

DIR gets index.html, which any browser opens, report.json with the same numbers, and detections.jsonl.
Exit codes: 0 done, 1 failed while running, 2 refused input, 130 interrupted; what was written before stays."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "demo",
        help="see it work without a robot",
        description="Drives a simulated robot through a world, detects on the way, and writes a report about it.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--world", default="laboratory", help="laboratory, office, street, storeroom, or a TOML file")
    add("--out", type=Path, metavar="DIR", help="folder for the report (default: out/demo)")
    add("--overwrite", action="store_true", help="replace the report in DIR")
    add("--model", type=Path, default=LAB_MODEL, help="model folder (default: the simulator's own)")
    add("--seed", type=seed_number, default=0, metavar="N", help="of light, noise and slip (default: 0)")
    add("--view", action="store_true", help="show it live in a browser on this machine, in real time")
    add("--port", type=whole_number(0, 2**16 - 1), metavar="N", help="of the live view (default: a free one)")
    add("--json", action="store_true", help="print the numbers as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Drives, detects, writes the report. Raises RefusedError."""
    import shlex
    import sys

    import msgspec

    from edgefusion.sim.world_file import load_world
    from edgefusion.tools.demo_run import DemoOptions, run_demo
    from edgefusion.tools.report_plots import check_matplotlib
    from edgefusion.tools.results import results_path

    if args.port is not None and not args.view:
        raise RefusedError(f"--port {args.port}: expected --view beside it")
    check_matplotlib()
    options = DemoOptions(
        world=load_world(args.world),
        out=results_path(args.out, "demo", args.overwrite),
        overwrite=args.overwrite,
        model=args.model,
        seed=args.seed,
        port=(args.port or 0) if args.view else None,
        command=shlex.join(["edgefusion", *sys.argv[1:]]),
    )
    report = run_demo(options)
    print(msgspec.json.encode(report).decode() if args.json else _as_text(report, options.out))
    return 0


def _as_text(report: dict[str, Any], out: Path) -> str:
    drive, objects, error = report["drive"], report["objects"], report["distance_error_mm"]
    median = "none measured" if error["median"] is None else f"{error['median']:.0f} mm"
    return "\n".join(
        [
            f"found:           {objects['found']} of {objects['in_view']} objects, {objects['named']} named right",
            f"distance error:  {median} (median)",
            f"drive:           {drive['way_m']:.1f} m in {drive['duration_s']:.1f} s, {report['frames']} frames",
            f"took:            {report['took_s']:.1f} s",
            f"report:          {out / 'index.html'}",
        ]
    )
