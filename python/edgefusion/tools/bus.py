# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion bus`: the router by which a robot's processes and its laptops find each other."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = """examples:
  edgefusion bus
  edgefusion bus --config robot.toml

Without keys it listens on this computer alone, where every program may do everything. With them (`edgefusion keys`) the
section [bus] may have it listen on a network: viewers read, operators command, everyone else gets nothing.
`edgefusion run` starts it beside the others. Ctrl-C and SIGTERM end it.
Exit codes: 0 ended as asked, 1 it cannot listen there, 2 refused."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "bus",
        help="run the router of a robot's bus",
        description="Runs the Zenoh router of a robot's bus.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--config", type=Path, metavar="FILE", help="the robot's TOML file; its [bus]")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Until it is asked to end. Raises RefusedError, OSError."""
    from contextlib import suppress

    from edgefusion.config import load_config
    from edgefusion.service.bus_process import COMPONENT, run_bus
    from edgefusion.service.heartbeat import from_environment
    from edgefusion.service.logs import set_up_logs
    from edgefusion.service.signals import ended_by_signals

    config = load_config(args.config)
    set_up_logs(COMPONENT, config.service.log_level)
    with suppress(KeyboardInterrupt), ended_by_signals():
        run_bus(config.bus, from_environment())
    return 0
