# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion topics`: what is on a robot's bus, of which types, how often."""

from __future__ import annotations

import argparse

from edgefusion.tools.bus_options import add_bus, open_robot
from edgefusion.tools.device_options import check_above_0

EXAMPLES = """examples:
  edgefusion topics
  edgefusion topics --seconds 10 --connect tls/robot.local:7447
  edgefusion topics --json

Listens to all of them for a while, also to images, which are encoded only while somebody listens.
Exit codes: 0 done, 1 no bus, or nothing came, 2 refused, 130 interrupted."""

INTERRUPTED = 130


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "topics",
        help="list what is on a robot's bus",
        description="Lists the topics of a robot's bus with their types, rates and sizes.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seconds", type=float, default=3.0, metavar="S", help="to listen (default: 3)")
    parser.add_argument("--json", action="store_true", help="a line of JSON for each topic")
    add_bus(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Listens, and lists. Raises RefusedError."""
    import json
    import sys

    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.topic_rates import in_words, listen

    check_above_0(args, "seconds")
    with ended_by_signals(INTERRUPTED), open_robot(args) as robot:
        heard = listen(robot.session, robot.name, args.seconds)
    print("\n".join(json.dumps(each._asdict()) for each in heard) if args.json else "\n".join(in_words(heard)))
    if any(each.messages for each in heard):
        return 0
    print(f"edgefusion: topics: nothing came of a robot named {robot.name!r}; --robot names another", file=sys.stderr)
    return 1
