# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""All benchmarks, one table: edgefusion beside named peers, in the same run on the same machine.

Times are medians of candidates that take turns; a ratio says how many times edgefusion does better than its peer.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import multiprocessing
import os
import platform
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Mapping, Sequence

EXAMPLES = """examples:
  python -m benchmarks.run
  python -m benchmarks.run --quick
  python -m benchmarks.run --only crops frame --out out/crops"""

PEERS = ("numpy", "onnxruntime", "opencv-python-headless", "scikit-learn", "scipy", "dbscan", "pillow")

Record = Mapping[str, Any]
"""A row of the table as plain values; `said` in the place of numbers where there are none."""


@dataclass(frozen=True)
class Part:
    """A module with `rows`, and what --quick passes to it."""

    module: str
    quick: Mapping[str, int]


PARTS = {
    "dbscan": Part("bench_dbscan", {"rounds": 3}),
    "crops": Part("bench_crops", {"rounds": 10}),
    "frame": Part("bench_frame", {"rounds": 3}),
    "raycast": Part("bench_raycast", {"rounds": 5}),
    "navigation": Part("bench_navigation", {"rounds": 3}),
    "detect": Part("bench_detect", {"rounds": 1, "frames": 5}),
}


def main(argv: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(argv)
    records: list[Record] = []
    for number, name in enumerate(args.only, 1):
        print(f"[{number}/{len(args.only)}] {name} ...", file=sys.stderr, flush=True)
        start = time.perf_counter()
        records += run_part(name, args.quick)
        print(f"[{number}/{len(args.only)}] {name}: {time.perf_counter() - start:.0f} s", file=sys.stderr, flush=True)
    table = markdown(HEADER, [cells(record) for record in records])
    print(table)
    print(f"written to {write_results(args.out, 'table', records, table)}", file=sys.stderr)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.run",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="fewer rounds: under two minutes, noisier")
    parser.add_argument(
        "--only", nargs="+", choices=PARTS, default=list(PARTS), metavar="NAME", help=f"of {', '.join(PARTS)}"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("out/bench"), metavar="DIR", help="folder for the table (default: out/bench)"
    )
    return parser


def run_part(name: str, quick: bool) -> list[Record]:
    """The rows of a part, measured in a process of its own: settings and memory of one do not reach the next."""
    part = PARTS[name]
    context = multiprocessing.get_context("spawn")
    try:
        with ProcessPoolExecutor(max_workers=1, mp_context=context) as process:
            return process.submit(_measure, part.module, dict(part.quick) if quick else {}).result()
    except Exception as error:  # a benchmark that cannot run must not take the others' results with it
        said = " ".join(str(error).split()) or type(error).__name__
        hint = " (pip install 'edgefusion[bench]')" if isinstance(error, ImportError) else ""
        return [{"name": name, "said": f"not measured: {said}{hint}"}]


def _measure(module: str, options: Mapping[str, int]) -> list[Record]:
    rows: Sequence[Any] = importlib.import_module(f"benchmarks.{module}").rows(**options)
    return [asdict(row) for row in rows]


HEADER = ("what", "edgefusion", "peer", "peer's", "ratio", "aim", "")


def cells(record: Record) -> list[str]:
    """A row of the table as text."""
    if "said" in record:
        return [record["name"], "-", record["said"], "-", "-", "-", ""]
    ratio, aim, unit = record["ratio"], record["aim"], record.get("unit", "s")
    return [
        record["name"],
        quantity(record["product_s"], unit),
        record["peer"],
        quantity(record["peer_s"], unit),
        f"{ratio:.3g}" if math.isfinite(ratio) else "-",
        "-" if aim is None else f"{aim:.3g}",
        "" if aim is None or not math.isfinite(ratio) else "met" if ratio >= aim else "missed",
    ]


def quantity(value: float, unit: str) -> str:
    """A median in a fitting unit: 's', 'MB', or 'frame', which also says how many a second."""
    if not math.isfinite(value):
        return "-"
    if unit == "MB":
        return f"{value:.0f} MB"
    scale, name = next((s, n) for s, n in ((1, "s"), (1e3, "ms"), (1e6, "us")) if value * s >= 1 or n == "us")
    text = f"{value * scale:.3g} {name}"
    return f"{text} ({1 / value:.3g}/s)" if unit == "frame" else text


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table that also reads well in a terminal."""
    widths = [max(3, *(len(row[column]) for row in (header, *rows))) for column in range(len(header))]
    rule = ["-" * width for width in widths]
    lines = [" | ".join(cell.ljust(width) for cell, width in zip(row, widths)) for row in (header, rule, *rows)]
    return "\n".join(f"| {line} |" for line in lines)


def write_results(folder: Path, name: str, records: Sequence[Record], table: str) -> Path:
    """NAME.json and NAME.md, both with the facts of the machine. Returns the latter's path."""
    folder.mkdir(parents=True, exist_ok=True)
    machine = machine_facts()
    content = {"machine": machine, "rows": [_finite(record) for record in records]}
    (folder / f"{name}.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    facts = ", ".join(f"{key} {value}" for key, value in machine.items())
    path = folder / f"{name}.md"
    path.write_text(f"{table}\n\n{facts}\n", encoding="utf-8")
    return path


def _finite(record: Record) -> Record:
    """JSON knows no NaN."""
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value for key, value in record.items()
    }


def machine_facts() -> dict[str, str]:
    """What the numbers depend on."""
    facts = {"CPU": _cpu_model(), "cores": str(os.cpu_count()), "Python": platform.python_version()}
    return {**facts, **{peer: _version(peer) for peer in PEERS}}


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


if __name__ == "__main__":
    sys.exit(main())
