# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion base`: robot, laser, navigation and safety, commanded over the bus."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = """examples:
  edgefusion base --config robot.toml

Drives the robot of [robot] by the laser of [laser], and says on the bus of [bus] what it sees and does. It starts and
drives without a bus, and joins it whenever there is one. However it ends, the last that the robot hears is to stop.
`edgefusion run` starts it beside the others, and stops the robot should it die. Ctrl-C and SIGTERM end it.
Exit codes: 0 ended as asked, 1 failed, 2 refused, as a port that another process holds."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "base",
        help="drive the robot, commanded over the bus",
        description="Runs the base of a robot: its motors, its laser, navigation and safety.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="TOML; `edgefusion config init`")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Until it is asked to end. Raises RefusedError."""
    from contextlib import suppress

    from edgefusion.config import load_config
    from edgefusion.service.base_process import BaseProcess
    from edgefusion.service.base_reports import COMPONENT
    from edgefusion.service.heartbeat import from_environment
    from edgefusion.service.logs import set_up_logs
    from edgefusion.service.signals import ended_by_signals

    config = load_config(args.config)
    set_up_logs(COMPONENT, config.service.log_level)
    with suppress(KeyboardInterrupt), ended_by_signals():
        BaseProcess(config, from_environment()).run()
    return 0
