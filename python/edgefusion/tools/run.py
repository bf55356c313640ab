# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion run`: all processes of the robot, watched."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = """examples:
  edgefusion run --config robot.toml

Starts the processes that the section [service] of the configuration names: bus, base and vision (without a
model in [vision] there is none). One that dies or falls silent is started again, base only after the robot was told to
stop. Ctrl-C and SIGTERM end it within three seconds.
Under systemd (deploy/jetson/edgefusion.service) it says when it is ready, and that it lives.
Exit codes: 0 ended as asked, 1 a process was given up, or the robot may still move, 2 refused."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "run",
        help="run everything on the robot, as a service does",
        description="Runs and watches the processes of a robot.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="TOML; `edgefusion config init`")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Until it is asked to end. Raises RefusedError."""
    import faulthandler
    import logging

    from edgefusion.config import load_config
    from edgefusion.service.children import children_of
    from edgefusion.service.logs import set_up_logs
    from edgefusion.service.supervisor import Supervisor

    config = load_config(args.config)
    set_up_logs("supervisor", config.service.log_level)
    faulthandler.enable()  # systemd's watchdog ends what hangs by SIGABRT: then it is said where
    if config.processes != config.service.processes:
        logging.getLogger(__name__).info("vision: not started: [vision] has no model, and the robot only drives")
    return Supervisor(children_of(config, args.config.resolve())).run()
