# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults injected into devices, processes and time as they run, and how long until what must happen has happened.

Each figure with its median and its worst beside the aim. Machines are loaded: only what takes more than three times as
long as it may, or comes to something else than it must, makes this exit with 1.
"""

from __future__ import annotations

import argparse
import importlib
import logging
import math
import signal
import sys
from dataclasses import asdict
from pathlib import Path
from typing import List, Sequence

from benchmarks.fault_row import FaultRow
from benchmarks.run import markdown, write_results
from tqdm import tqdm

from edgefusion.tools.arguments import whole_number

EXAMPLES = """examples:
  python -m benchmarks.faults
  python -m benchmarks.faults --only C --seeds 3
  python -m benchmarks.faults --only L,R --out out/faults

Exit codes: 0 as it should be, or no worse than a loaded machine explains, 1 otherwise."""

PARTS = {
    "L": ("laser",),
    "R": ("robot",),
    "C": ("camera",),
    "S": ("time",),
    "I": ("inference", "model"),
    "Z": ("bus",),
    "P": ("supervisor",),
    "Y": ("recording", "base"),
}
HEADER = ("figure", "fault, and until what", "aim", "median", "worst", "runs", "", "remark")


def main(argv: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(argv)
    found: List[FaultRow] = []
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs, and their children, ignore it
    logging.disable(logging.ERROR)  # the drivers tell what is done to them
    for part in [part for letter in args.only for part in PARTS[letter]]:
        module = importlib.import_module(f"benchmarks.faults_{part}")
        with tqdm(desc=part, unit="run", disable=None) as bar:
            found += module.rows(args.seeds, bar.update)
    table = markdown(HEADER, [cells(row) for row in found])
    print(table)
    records = [{**asdict(row), "met": row.met, "broken": row.broken} for row in found]
    print(f"written to {write_results(args.out, 'faults', records, table)}", file=sys.stderr)
    for row in found:
        if row.broken:
            print(f"{row.figure}: {row.what}: expected {row.aim}", file=sys.stderr)
    return int(any(row.broken for row in found))


def cells(row: FaultRow) -> List[str]:
    """A line of the table."""
    word = "broken" if row.broken else "met" if row.met else "missed"
    times = [_shown(row.median_s), _shown(row.worst_s)] if row.seconds else ["", ""]
    return [row.figure, row.what, row.aim, *times, str(len(row.seconds) or ""), word, row.remark]


def _shown(seconds: float) -> str:
    if math.isinf(seconds):
        return "never"
    return f"{1e3 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.2f} s"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.faults",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only",
        type=_letters,
        default=list(PARTS),
        metavar=",".join(PARTS),
        help="laser, robot, camera, time, inference, bus, processes, system (default: all)",
    )
    parser.add_argument("--seeds", type=whole_number(1, 1000), default=5, metavar="N", help="runs of each (default: 5)")
    parser.add_argument(
        "--out", type=Path, default=Path("out/faults"), metavar="DIR", help="folder for the table (default: out/faults)"
    )
    return parser


def _letters(text: str) -> List[str]:
    letters = text.split(",")
    if not letters or not set(letters) <= set(PARTS):
        raise argparse.ArgumentTypeError(f"expected some of {','.join(PARTS)}, got {text}")
    return letters


if __name__ == "__main__":
    sys.exit(main())
