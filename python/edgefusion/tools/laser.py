# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion laser`: what scanner is connected, how it is, and what it sees."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from edgefusion.errors import RefusedError
from edgefusion.tools.device_options import add_device_options, check_above_0

if TYPE_CHECKING:
    from edgefusion.config import LaserConfig

EXAMPLES = """examples:
  edgefusion laser /dev/ttyUSB1
  edgefusion laser /dev/ttyUSB1 --baudrate 500000 --beams 361
  edgefusion laser /dev/ttyUSB1 --once --png scan.png
  edgefusion laser /dev/ttyUSB1 --json --seconds 10 > scans.jsonl

In a terminal the scan is drawn anew twice a second, the scanner at the bottom, looking up; Ctrl-C ends it. A scanner
that is lost is searched again.
Exit codes: 0 done, 1 no scanner, or not the one scan, 2 refused, as a port that another process holds,
130 interrupted."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The verb's options."""
    parser = subparsers.add_parser(
        "laser",
        help="show what a SICK LMS2xx on a port sees, and how it is",
        description="Finds a SICK LMS2xx at whatever speed it was left, sets it up as configured, and shows its scans.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_device_options(parser, "[laser]", "end after one scan", "scan")
    add = parser.add_argument
    add("--baudrate", type=int, choices=(38400, 500000), help="instead of the configuration's")
    add("--beams", type=int, choices=(101, 181, 201, 361, 401), help="instead of the configuration's")
    add("--png", type=Path, metavar="FILE", help="draw the last scan into a file, and nothing in the terminal")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Shows scans until it is told to end. Raises RefusedError."""
    import sys
    import time

    from edgefusion.drivers.link import Link, LinkError
    from edgefusion.drivers.lms2xx import Lms2xx
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.laser_watch import LaserWatch, watch

    check_above_0(args, "seconds")
    if args.png is not None and args.png.suffix != ".png":
        raise RefusedError(f"--png {args.png}: expected a name that ends in .png")
    config = _config(args)
    link = Link(args.port, config.baudrate, "edgefusion laser")
    laser = Lms2xx(link, config)
    shown = LaserWatch(args.png, args.json, sys.stdout.isatty() and not args.json and args.png is None)
    try:
        with ended_by_signals():
            laser.start()
            shown.begin(laser, link.baudrate)
            watch(laser, shown, args.once, args.seconds, time.monotonic_ns)
    except LinkError as error:
        raise RuntimeError(str(error)) from error
    finally:
        laser.close()
    shown.end()
    return 1 if args.once and not shown.has_scan else 0


def _config(args: argparse.Namespace) -> LaserConfig:
    import msgspec

    from edgefusion.config import load_config

    config = load_config(args.config).laser
    changes = {name: getattr(args, name) for name in ("baudrate", "beams") if getattr(args, name) is not None}
    return msgspec.structs.replace(config, **changes)
