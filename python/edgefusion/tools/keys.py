# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion keys`: makes a certificate authority of one's own, and the keys of robots, operators and viewers."""

from __future__ import annotations

import argparse
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

from edgefusion.errors import RefusedError
from edgefusion.tools.arguments import whole_number

# As in bus.key_files, which `--help` need not import.
ROLES = ("robot", "operator", "viewer")
FOLDER = Path("edgefusion-keys")

EXAMPLES = """\
examples:
  edgefusion keys init --host robot.local 192.168.0.5
      makes ./edgefusion-keys: ca, robot, operator and viewer
  edgefusion keys add lab-tablet --role viewer
      one more folder, for one more machine; nothing is changed on the robot

Whoever has the folder ca can let in anybody: it stays where it is. The keys of one machine cannot be called back; where
some are lost, make all of them anew.

Exit status: 0 done, 2 refused; the last line says why.
"""


def add_parser(subparsers: Any) -> None:
    """Adds the verb `keys` to the command line; each command sets `run`, which takes the arguments."""
    parser = subparsers.add_parser(
        "keys",
        help="make the keys that let the robot listen on a network",
        description="Makes keys: with them the robot listens on a network, viewers read, operators command, and "
        "everyone else gets nothing.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="keys_command", required=True, metavar="COMMAND")
    _add_init(commands)
    _add_add(commands)


def _add_init(commands: Any) -> None:
    parser = commands.add_parser("init", help="make a CA, and keys for a robot, an operator and a viewer")
    parser.add_argument(
        "--host", nargs="+", required=True, metavar="NAME_OR_IP", help="by which the robot is found on the network"
    )
    parser.add_argument("--out", type=Path, default=FOLDER, metavar="FOLDER", help="to make (default: %(default)s)")
    parser.add_argument("--years", type=whole_number(1, 100), default=10, help="of validity (default: %(default)s)")
    parser.set_defaults(run=run_init)


def _add_add(commands: Any) -> None:
    parser = commands.add_parser("add", help="make keys for one more machine")
    parser.add_argument("name", metavar="NAME", help="of the machine or of who uses it")
    parser.add_argument("--role", required=True, choices=ROLES, help="robot: a machine that runs vision, for one")
    parser.add_argument(
        "--keys", type=Path, default=FOLDER, metavar="FOLDER", help="that `init` has made (default: %(default)s)"
    )
    parser.set_defaults(run=run_add)


def run_init(args: argparse.Namespace) -> int:
    """Raises RefusedError."""
    until = datetime.now(timezone.utc).replace(tzinfo=None) + timedelta(days=366 * args.years)
    _key_folder().init(args.out, args.host, until)
    print(f"{args.out / 'ca'}: stays here; whoever has it can let in anybody")
    print(f"{args.out / 'robot'}: for the robot, whose configuration then says")
    print('    [bus]\n    keys = "WHERE YOU PUT IT"\n    listen = ["tls/0.0.0.0:7447"]')
    for role in ("operator", "viewer"):
        _say_where(args.out / role)
    return 0


def run_add(args: argparse.Namespace) -> int:
    """Raises RefusedError."""
    _say_where(_key_folder().add(args.keys, args.name, args.role))
    return 0


def _say_where(folder: Path) -> None:
    print(f"{folder}: for a machine of that role, as its ~/.config/edgefusion/keys")


def _key_folder() -> Any:
    try:
        from edgefusion.bus import key_folder
    except ModuleNotFoundError as error:
        raise RefusedError(f"keys: expected the package {error.name}: pip install 'edgefusion[keys]'") from error
    return key_folder
