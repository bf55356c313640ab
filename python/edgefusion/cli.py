# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The command line: one verb, one module of tools."""

from __future__ import annotations

import argparse
import logging
import sys
from typing import Sequence

from edgefusion import __version__
from edgefusion.errors import RefusedError

EXAMPLES = """examples:
  edgefusion demo
  edgefusion detect drive --model models/resnet18 --images
  edgefusion model add net.onnx --labels labels.txt --out models/net"""


def build_parser() -> argparse.ArgumentParser:
    """The parser of all verbs; each verb's module registers its own options and loads what it needs when run."""
    from edgefusion.tools import demo, detect, model

    parser = argparse.ArgumentParser(
        prog="edgefusion",
        description="Names and distances of the objects in front of a robot, from a 2D laser and a camera.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"edgefusion {__version__}")
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    for tool in (demo, detect, model):
        tool.add_parser(verbs)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a verb. Returns the exit code: 0 done, 2 refused input, 130 interrupted."""
    logging.basicConfig(level=logging.WARNING, format="edgefusion: %(levelname)s: %(message)s")
    args = build_parser().parse_args(argv)
    try:
        code: int = args.run(args)
    except RefusedError as error:
        print(f"edgefusion: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("edgefusion: interrupted", file=sys.stderr)
        return 130
    return code


if __name__ == "__main__":
    sys.exit(main())
