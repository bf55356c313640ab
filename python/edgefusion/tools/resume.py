# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion resume`: the robot may drive again."""

from __future__ import annotations

import argparse

from edgefusion.tools.bus_options import add_bus, open_robot

EXAMPLES = """examples:
  edgefusion resume
  edgefusion resume --connect tls/robot.local:7447

Leaves a stop, and gives the robot back to its mission after an operator drove it. An operator's keys are needed.
A robot that requires an operator stops again when this ends: `edgefusion goto --resume` stays.
Exit codes: 0 done, 1 nobody answered, 2 refused."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "resume",
        help="let a robot drive again that was stopped",
        description="Lets a robot drive on to its goals after a stop, or after an operator drove it.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_bus(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Raises RefusedError, and UnreachableError where nobody answers."""
    from edgefusion.tools.attending import attending

    with open_robot(args) as robot, attending(robot):
        robot.resume()
    print("resumed")
    return 0
