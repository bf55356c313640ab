# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion robot`: what robot is connected and how it is, and driving it by the keyboard."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from edgefusion.tools.device_options import add_device_options, check_above_0

if TYPE_CHECKING:
    from edgefusion.config import Config
    from edgefusion.drivers.pioneer import Pioneer

EXAMPLES = """examples:
  edgefusion robot /dev/ttyUSB0
  edgefusion robot /dev/ttyUSB0 --watch
  edgefusion robot socket://192.168.1.32:8101 --speed 0.1
  edgefusion robot /dev/ttyUSB0 --json --seconds 10 > robot.jsonl
  edgefusion robot /dev/ttyUSB0 --once

In a terminal it is driven: arrows or W A S D, for as long as a key is repeated; space stops, M switches the motors,
Q quits. Nothing but the keys looks where it goes: no laser, no sonar. However it ends, the robot is told to stop.
With --watch, --json, --once, or without a terminal it is only looked at, and its motors are not switched on.
Exit codes: 0 done, 1 no robot, 2 refused, as a port that another process holds, 130 interrupted."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "robot",
        help="see and drive the robot that is connected",
        description="Shows what Pioneer is connected and how it is, and drives it by the keyboard.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_device_options(parser, "[robot] and [base]", "tell it once, and end", "second")
    add = parser.add_argument
    add("--speed", type=float, default=0.2, metavar="M/S", help="of the keys (default: 0.2)")
    add("--turn-rate", type=float, default=30.0, metavar="DEG/S", help="of the keys (default: 30)")
    add("--watch", action="store_true", help="only look; the motors are not switched on")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Watches or drives until it is ended; the last that the robot hears is to stop. Raises RefusedError."""
    import sys
    import time

    from edgefusion.config import load_config
    from edgefusion.drivers.link import LinkError
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.robot_keys import Keys
    from edgefusion.tools.robot_loop import show_in_place, tell
    from edgefusion.tools.robot_watch import RobotWatch

    check_above_0(args, "speed", "turn_rate", "seconds")
    looks = args.watch or args.once or args.json or not (sys.stdin.isatty() and sys.stdout.isatty())
    keys = None if looks else Keys(args.speed, math.radians(args.turn_rate))
    with ended_by_signals(), _driver(args.port, load_config(args.config), keys is not None) as driver:
        watch = RobotWatch(args.port, driver, keys, time.monotonic_ns)
        try:
            watch.begin()
        except LinkError as error:
            raise RuntimeError(str(error)) from error
        if args.json or args.once or not sys.stdout.isatty():
            return tell(watch, args.json, args.once, args.seconds)
        return show_in_place(watch, keys, args.seconds)


def _driver(port: str, config: Config, drives: bool) -> Pioneer:
    import msgspec

    from edgefusion.drivers.link import Link
    from edgefusion.drivers.pioneer import Pioneer

    robot = msgspec.structs.replace(config.robot, enable_motors=config.robot.enable_motors and drives)
    return Pioneer(Link(port, robot.baudrates[0], "edgefusion robot"), robot, config.base)
