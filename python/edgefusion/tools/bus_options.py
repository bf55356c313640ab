# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the verbs that are clients of a robot's bus take."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Optional

if TYPE_CHECKING:
    from edgefusion.bus.client import Robot
    from edgefusion.config import BusConfig


class Endpoint(NamedTuple):
    """Where a robot's bus is and how it is entered."""

    robot: str
    address: str
    keys: Optional[Path]
    lease_s: float


def add_bus(parser: argparse.ArgumentParser) -> None:
    """Where the bus is."""
    parser.add_argument("--config", type=Path, metavar="FILE", help="the robot's TOML file, with its [bus]")
    parser.add_argument(
        "--connect",
        metavar="ENDPOINT",
        help="the robot's bus, as tls/robot.local:7447 (default: that of this computer)",
    )
    keys_help = "for tls, of `edgefusion keys` (default: $EDGEFUSION_KEYS, else ~/.config/edgefusion/keys)"
    parser.add_argument("--keys", type=Path, metavar="FOLDER", help=keys_help)
    parser.add_argument("--robot", metavar="NAME", help="its name on the bus (default: robot)")


def bus_config(args: argparse.Namespace) -> BusConfig:
    """The file's [bus], or its defaults, with --robot. Raises RefusedError."""
    import msgspec

    from edgefusion.config import load_config

    config = load_config(args.config).bus
    return config if args.robot is None else msgspec.structs.replace(config, robot=args.robot)


def asked_endpoint(args: argparse.Namespace) -> Endpoint:
    """Raises RefusedError for a configuration that will not do."""
    from edgefusion.bus.key_files import usual_folder

    config = bus_config(args)
    address = args.connect or config.router
    keys = args.keys or (None if config.keys is None else Path(config.keys))
    if keys is None and address.startswith("tls/"):
        keys = usual_folder(os.environ, Path.home())
    return Endpoint(config.robot, address, keys, config.lease_s)


def open_robot(args: argparse.Namespace) -> Robot:
    """The robot that was asked for. Raises RefusedError, and UnreachableError where no router lets us in."""
    from edgefusion.bus.client import Robot
    from edgefusion.bus.session import open_client

    endpoint = asked_endpoint(args)
    return Robot(open_client(endpoint.address, endpoint.keys, lease_s=endpoint.lease_s), endpoint.robot)
