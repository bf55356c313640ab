# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion goto`: drive to a place, and tell how it goes until it is done."""

from __future__ import annotations

import argparse
import math
import re

from edgefusion.tools.bus_options import add_bus, open_robot

EXAMPLES = """examples:
  edgefusion goto 5 5.5
  edgefusion goto 5 5.5 15deg --inspect oscilloscope --inspect "power supply"
  edgefusion goto -1 0 -90deg --relative --connect tls/robot.local:7447

X and Y in metres, the heading as 15deg or 0.26rad, in odom: from where the robot was switched on, x forward, y left.
Ctrl-C gives the goal up and stops the robot, until `edgefusion resume`; so does a pipe that nobody reads any more.
--resume leaves a stop; the goals that were left are given up. An operator's keys are needed.
Exit codes: 0 arrived, 1 nobody answered or the robot fell silent, 2 refused, 3 it did not arrive, 130 interrupted."""

_HEADING = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(deg|rad)")
_NUMBERS = re.compile(r"-(?:\d+\.?\d*|\.\d+)(?:deg|rad)?$")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "goto",
        help="drive a robot to a place",
        description="Drives a robot to a place, instead of to the goals that it has, and tells how it goes.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser._negative_number_matcher = _NUMBERS  # else argparse takes -15deg for an option
    add = parser.add_argument
    add("x", type=float, metavar="X", help="[m]")
    add("y", type=float, metavar="Y", help="[m]")
    add("theta", type=heading, nargs="?", metavar="HEADING", help="to look in there (default: any)")
    add("--relative", action="store_true", help="from where the robot stands now, x ahead of it")
    add("--inspect", action="append", metavar="LABEL", help="take a picture of such things on the way (again for more)")
    add("--resume", action="store_true", help="leave a stop first, without the goals that were left")
    add("--json", action="store_true", help="each report of the robot as a line of JSON")
    add_bus(parser)
    parser.set_defaults(run=run)


def heading(text: str) -> float:
    """[rad], of a text with its unit."""
    found = _HEADING.fullmatch(text)
    if found is None:
        raise argparse.ArgumentTypeError(f"expected an angle as 15deg or 0.26rad, got {text!r}")
    value = float(found[1])
    return math.radians(value) if found[2] == "deg" else value


def run(args: argparse.Namespace) -> int:
    """Drives there. Raises RefusedError, and UnreachableError where the robot does not answer or falls silent."""
    from edgefusion.bus.requests import GoalRequest
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.attending import attending
    from edgefusion.tools.goto_drive import INTERRUPTED, RESUMING_S, drive, leave_stop
    from edgefusion.tools.goto_show import shown

    goal = GoalRequest(args.x, args.y, args.theta, frame="base_link" if args.relative else "odom")
    with ended_by_signals(INTERRUPTED), open_robot(args) as robot, attending(robot):
        if args.resume:
            leave_stop(robot)
        return drive(robot, goal, args.inspect, shown(args.json), RESUMING_S if args.resume else 0.0)
