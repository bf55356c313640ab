# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A robot that drives for a long time while something goes wrong every minute, in real time with all processes.

Its devices are simulated, on ptys; an operator gives one goal after the other and a recorder records. Told are whether
it stood in time, touched something, or lost a process, and whether a process grows. Machines are loaded: exit code 1
means a contact, a process that ended by itself, a robot that did not drive again, or more than three times an aim.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Sequence

from benchmarks.run import write_results
from benchmarks.soak_faults import FAULTS
from benchmarks.soak_report import Result, line_of, tables, tracebacks
from benchmarks.soak_rig import SoakRig
from benchmarks.soak_run import Soak
from tqdm import tqdm

from edgefusion.errors import RefusedError
from edgefusion.tools.arguments import seed_number, whole_number

EXAMPLES = """examples:
  python -m benchmarks.soak
  python -m benchmarks.soak --minutes 2 --period 10
  python -m benchmarks.soak --minutes 60 --seed 7 --out out/soak-60

Exit codes: 0 as it should be, or no worse than a loaded machine explains, 1 otherwise, 2 refused."""


def main(argv: Sequence[str] | None = None) -> int:
    parser = _parser()
    args = parser.parse_args(argv)
    args.out.mkdir(parents=True, exist_ok=True)
    try:
        result = soak(args)
    except RefusedError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    table = tables(result)
    print(table)
    records = [{"minutes": args.minutes, "seed": args.seed, **result.record}]
    print(f"written to {write_results(args.out, 'soak', records, table)}", file=sys.stderr)
    for wrong in result.broken:
        print(wrong, file=sys.stderr)
    return int(bool(result.broken))


def soak(args: argparse.Namespace) -> Result:
    """All of it. The logs of the processes are kept in the folder of the results."""
    total_s = 60.0 * args.minutes
    rig = SoakRig(args.out.resolve(), args.seed, min(600.0, total_s / 3))
    wrong: list[str] = []
    try:
        rig.begin()
        with tqdm(total=round(total_s), desc="soak", unit="s", disable=None) as bar:
            run = Soak(rig, args.period, total_s, lambda happened: bar.write(line_of(happened), file=sys.stderr))
            run.run(FAULTS, lambda seconds: bar.update(round(seconds)))
    finally:
        wrong += rig.close()
    wrong += tracebacks(rig.folder)
    return Result(
        run.happened, rig.traces.growths(), rig.contacts, [*rig.crashes, *wrong], dict(rig.goals), rig.traces.series
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.soak",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--minutes", type=whole_number(1, 10_000), default=30, metavar="N", help="how long (default: 30)")
    add("--period", type=whole_number(5, 3600), default=60, metavar="S", help="a fault every so often (default: 60)")
    add("--seed", type=seed_number, default=0, help="of the faults, goals and noise (default: 0)")
    add("--out", type=Path, default=Path("out/soak"), metavar="DIR", help="for tables, logs, recording (out/soak)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
