# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the verbs that are clients of a robot's bus take."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Optional

if TYPE_CHECKING:
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
    parser.add_argument("--connect", metavar="ENDPOINT", help="of the router, as tls/robot.local:7447")
    parser.add_argument("--keys", type=Path, metavar="FOLDER", help="of this machine, as `edgefusion keys` makes it")
    parser.add_argument("--robot", metavar="NAME", help="the first part of its keys (default: robot)")


def bus_config(args: argparse.Namespace) -> BusConfig:
    """The file's [bus], or its defaults, with --robot. Raises RefusedError."""
    import msgspec

    from edgefusion.config import load_config

    config = load_config(args.config).bus
    return config if args.robot is None else msgspec.structs.replace(config, robot=args.robot)


def asked_endpoint(args: argparse.Namespace) -> Endpoint:
    """Raises RefusedError for a configuration that will not do."""
    config = bus_config(args)
    keys = args.keys or (None if config.keys is None else Path(config.keys))
    return Endpoint(config.robot, args.connect or config.router, keys, config.lease_s)
