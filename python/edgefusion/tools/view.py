# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion view`: what a robot sees and does, in Rerun."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from edgefusion.errors import RefusedError
from edgefusion.tools.arguments import whole_number
from edgefusion.tools.bus_options import add_bus, open_robot
from edgefusion.tools.device_options import check_above_0

EXAMPLES = """examples:
  edgefusion view --connect tls/robot.local:7447
  edgefusion view --web
  edgefusion view --save drive.rrd --seconds 60

Shows the image with boxes and labels, and the scan over it: where its points lie on edges, the calibration is right
(look while the robot stands). From above: scan, clusters, path, goal and robot. Beside it distances and stage times.
--web serves a page, for a machine without a screen: whoever reaches its ports sees what you see, without keys.
Ctrl-C ends it. A viewer's keys will do. Needs the extra: pip install 'edgefusion[viewer]'.
Exit codes: 0 done, 1 no bus, 2 refused, 130 interrupted."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "view",
        help="see what a robot sees, in Rerun",
        description="Shows a robot's images, scans, detections and ways in Rerun as they come.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--web", action="store_true", help="serve a page instead of opening a window")
    where.add_argument("--save", type=Path, metavar="FILE", help="write a new .rrd, for `rerun FILE`, instead")
    parser.add_argument("--web-port", type=whole_number(1, 65535), default=9090, metavar="PORT", help="default: 9090")
    parser.add_argument(
        "--data-port", type=whole_number(1, 65535), default=9876, metavar="PORT", help="of --web's data; default: 9876"
    )
    parser.add_argument("--seconds", type=float, default=math.inf, metavar="S", help="end after so long")
    add_bus(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Shows until it is ended. Raises RefusedError."""
    from edgefusion.recording.extras import require

    require("rerun", "viewer", "view")
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.view_feeds import show
    from edgefusion.tools.view_sink import open_recording

    check_above_0(args, "seconds")
    if args.save is not None and args.save.exists():
        raise RefusedError(f"{args.save}: exists already")
    with ended_by_signals(), open_robot(args) as robot, open_recording(
        args.save, args.web, args.web_port, args.data_port
    ) as recording:
        show(robot, recording, args.seconds)
    return 0
