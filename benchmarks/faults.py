# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What happens, and how soon, when a device fails: through real drivers, ptys, sockets and processes, in real time."""

from __future__ import annotations

import argparse
import logging
from importlib import import_module
from pathlib import Path
from typing import List, Sequence

from benchmarks.fault_row import ALLOWED, FaultRow
from tqdm import tqdm

PARTS = {"L": "laser", "R": "robot", "C": "camera"}

EXAMPLES = """examples:
  python -m benchmarks.faults
  python -m benchmarks.faults --only C --seeds 2

Exit codes: 0 all figures within three times their aim, since machines are loaded; 1 not."""


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the parts, writes the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.faults",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", default="L,R,C", help="of L, R, C: laser, robot, camera (default: all)")
    parser.add_argument("--seeds", type=int, default=5, metavar="N", help="how often each fault (default: 5)")
    parser.add_argument("--out", type=Path, default=Path("out/faults"), metavar="DIR", help="default: out/faults")
    args = parser.parse_args(argv)
    wanted = args.only.split(",")
    if not set(wanted) <= set(PARTS) or args.seeds < 1:
        parser.error(f"expected parts of {', '.join(PARTS)} and at least one seed, got {args.only}, {args.seeds}")
    logging.disable(logging.ERROR)  # the drivers say what is done to them
    rows = [row for part in wanted for row in _rows(PARTS[part], args.seeds)]
    table = _table(rows)
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "faults.md").write_text(table, encoding="utf-8")
    print(table + f"written to {args.out / 'faults.md'}")
    return 1 if any(row.broken for row in rows) else 0


def _rows(part: str, seeds: int) -> List[FaultRow]:
    module = import_module(f"benchmarks.faults_{part}")
    with tqdm(total=module.runs(seeds), desc=part, unit="run") as progress:
        found: List[FaultRow] = module.rows(seeds, progress.update)
    return found


def _table(rows: Sequence[FaultRow]) -> str:
    lines = [
        "| figure | fault, and what is timed | aim | median | worst | of | |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        verdict = "met" if row.met else "MISSED"
        if row.remark:
            verdict += f": {row.remark}"
        times = f"{_ms(row.median_s)} | {_ms(row.worst_s)} | {len(row.seconds)}" if row.seconds else "- | - | -"
        lines.append(f"| {row.figure} | {row.what} | {row.aim} | {times} | {verdict} |")
    return "\n".join([*lines, "", f"Fails beyond {ALLOWED:g} times an aim.", ""])


def _ms(seconds: float) -> str:
    return f"{seconds * 1e3:.0f} ms" if seconds < float("inf") else "never"


if __name__ == "__main__":
    raise SystemExit(main())
