# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the verbs that look at a device on a port have in common on the command line."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from edgefusion.errors import RefusedError


def add_device_options(parser: argparse.ArgumentParser, sections: str, once: str, line: str) -> None:
    """The port, the configuration, and how long it is looked at. sections: of the file; line: what JSON tells of."""
    add = parser.add_argument
    add("port", metavar="PORT", help="a serial port, or socket://HOST:PORT")
    add("--config", type=Path, metavar="FILE", help=f"TOML; its {sections}")
    add("--once", action="store_true", help=once)
    add("--seconds", type=float, default=math.inf, metavar="S", help="end after so many")
    add("--json", action="store_true", help=f"one line of JSON for each {line}")


def check_above_0(args: argparse.Namespace, *names: str) -> None:
    """Raises RefusedError where one of the options is not."""
    for name in names:
        if not getattr(args, name) > 0:  # also of nan
            raise RefusedError(f"--{name.replace('_', '-')}: expected more than 0, got {getattr(args, name):g}")
