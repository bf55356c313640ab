# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion stop`: the robot stands still."""

from __future__ import annotations

import argparse

from edgefusion.tools.bus_options import add_bus, open_robot

EXAMPLES = """examples:
  edgefusion stop
  edgefusion stop --cancel --reason "the hall is closed" --connect tls/robot.local:7447

The robot stands until `edgefusion resume`. An operator's keys are needed.
Exit codes: 0 it has stopped, 1 nobody answered, 2 refused."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "stop",
        help="let a robot stand still",
        description="Stops a robot, whatever drives it, until it is told to resume.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--cancel", action="store_true", help="also give up the goals that are left")
    parser.add_argument("--reason", default="asked by an operator", metavar="TEXT", help="told to all who watch")
    add_bus(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Raises RefusedError, and UnreachableError where nobody answers."""
    with open_robot(args) as robot:
        robot.stop(args.reason, args.cancel)
    print("stopped" + (", its goals are given up" if args.cancel else "") + "; `edgefusion resume` lets it drive again")
    return 0
