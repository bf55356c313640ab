# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion recover`: mends a recording that ends in the middle."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from edgefusion.recording.recover import Mended

EXAMPLES = """examples:
  edgefusion recover drive.mcap
  edgefusion recover drive.mcap --cut-all

What is torn at the end of FILE, as after a power cut, is cut off, and the end that is missing is written; every message
that is whole stays. Copy the file first where it is the only one.
Exit codes: 0 FILE is whole now, 2 refused input; FILE is as it was then."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "recover",
        help="mend a recording that ends in the middle",
        description="Mends an MCAP file that was torn by a crash, a full disk or a power cut.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="the MCAP file")
    parser.add_argument("--cut-all", action="store_true", help="cut behind the first damage, however much there is")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Mends a file in its place. Raises RefusedError."""
    from edgefusion.recording.extras import require

    require("mcap", "record", "recover")
    from edgefusion.recording.recover import MOST_CUT_BYTES, recover

    found = recover(args.file, sys.maxsize if args.cut_all else MOST_CUT_BYTES)
    print(f"{args.file}: {_in_words(found)}")
    return 0


def _in_words(found: Mended) -> str:
    contents = f"{found.messages} messages of {found.duration_ns / 1e9:.1f} s"
    if found.was_whole:
        return f"whole, {contents}; nothing was to be done"
    return f"mended, {contents}; {found.cut_bytes} torn bytes were cut"
