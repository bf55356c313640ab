# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion vision`: the camera and the detector of a robot, on its bus."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = """examples:
  edgefusion vision --config robot.toml

Names what the camera of [camera] sees, with the model of [vision], and the scans and the odometry that `edgefusion
base` puts on the bus of [bus]. It starts without a bus, and joins it whenever there is one.
`edgefusion run` starts it beside the others. Ctrl-C and SIGTERM end it.
Exit codes: 0 ended as asked, 1 failed, as a GPU that is required does, 2 refused, as a model that is damaged."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "vision",
        help="name what the camera sees, on the robot's bus",
        description="Runs the vision of a robot: its camera and the detector.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="TOML; `edgefusion config init`")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Until it is asked to end. Raises RefusedError, RuntimeError."""
    from contextlib import suppress

    from edgefusion.config import load_config
    from edgefusion.service.heartbeat import from_environment
    from edgefusion.service.logs import set_up_logs
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.service.vision_bus import COMPONENT
    from edgefusion.service.vision_process import run_vision

    config = load_config(args.config)
    set_up_logs(COMPONENT, config.service.log_level)
    with suppress(KeyboardInterrupt), ended_by_signals():
        run_vision(config, from_environment())
    return 0
