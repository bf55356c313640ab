# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion teleop`: drive a robot over the bus by the keyboard."""

from __future__ import annotations

import argparse
import math

from edgefusion.errors import RefusedError
from edgefusion.tools.bus_options import add_bus, open_robot
from edgefusion.tools.device_options import check_above_0

EXAMPLES = """examples:
  edgefusion teleop
  edgefusion teleop --speed 0.1 --connect tls/robot.local:7447

Arrows or W A S D drive, for as long as a key is repeated; space stops, Q quits. The first key pauses the mission until
`edgefusion resume`. The robot's safety gate holds it before what its laser sees. An operator's keys are needed.
Exit codes: 0 done, 1 no bus, 2 refused, as where there is no terminal, 130 interrupted."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "teleop",
        help="drive a robot by the keyboard",
        description="Drives a robot over its bus by the keyboard, in a terminal.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--speed", type=float, default=0.2, metavar="M/S", help="of the keys (default: 0.2)")
    parser.add_argument("--turn-rate", type=float, default=30.0, metavar="DEG/S", help="of the keys (default: 30)")
    add_bus(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Drives until Q; the last that the robot hears is to stand. Raises RefusedError."""
    import sys

    from edgefusion.clock import system_clock
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.attending import attending
    from edgefusion.tools.robot_keys import Keys
    from edgefusion.tools.teleop_loop import Teleop, drive_in_terminal

    check_above_0(args, "speed", "turn_rate")
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise RefusedError("teleop: expected a terminal, for its keys")
    keys = Keys(args.speed, math.radians(args.turn_rate))
    with ended_by_signals(), open_robot(args) as robot, attending(robot):
        drive_in_terminal(Teleop(robot, keys, system_clock), keys)
    return 0
