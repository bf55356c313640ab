# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion watch`: what a robot sees and how it is, as a table."""

from __future__ import annotations

import argparse
import math

from edgefusion.tools.bus_options import add_bus, open_robot
from edgefusion.tools.device_options import check_above_0

EXAMPLES = """examples:
  edgefusion watch
  edgefusion watch --connect tls/robot.local:7447
  edgefusion watch --json --seconds 60 > robot.jsonl
  edgefusion watch --once

In a terminal the table is drawn in place, else it is told once a second. Ctrl-C ends it. A viewer's keys will do.
Exit codes: 0 done, 1 no bus, or with --once a robot that says nothing, 2 refused, 130 interrupted."""

INTERRUPTED = 130


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "watch",
        help="see what a robot detects and how it is",
        description="Shows a robot's detections, its mission and the states of its components as they come.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_bus(parser)
    parser.add_argument("--once", action="store_true", help="tell it once, and end")
    parser.add_argument("--json", action="store_true", help="a line of JSON each second")
    parser.add_argument("--seconds", type=float, default=math.inf, metavar="S", help="end after so long")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Watches until it is ended. Raises RefusedError."""
    import sys

    from edgefusion.clock import system_clock
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.watch_loop import Watch, show_in_place, tell, tell_once

    check_above_0(args, "seconds")
    with ended_by_signals(INTERRUPTED if args.once else 0), open_robot(args) as robot:
        watch = Watch(robot, system_clock)
        if args.once:
            return tell_once(watch, args.json)
        if args.json or not sys.stdout.isatty():
            return tell(watch, args.json, args.seconds)
        return show_in_place(watch, args.seconds)
