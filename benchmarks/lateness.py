# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How late the base's cycles begin, twenty a second, while vision with a real classifier fills all processors.

All processes of the robot run beside the simulated devices, in real time; the robot drives and turns. Once the base
may not ask for real-time scheduling, and once it may, as the systemd unit lets it. What is measured is what the base
says of itself on the bus. Exit code 1 means more than three times the aim.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any, Dict, List, Sequence

from benchmarks.end_to_end_robot import RobotSetup
from benchmarks.fault_row import ALLOWED
from benchmarks.lateness_rig import WINDOW_S, Load, loaded, unprivileged
from benchmarks.run import markdown, write_results

from edgefusion.bus.session import UnreachableError
from edgefusion.errors import RefusedError
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import read_labels
from edgefusion.service.signals import ended_by_signals
from edgefusion.tools.arguments import LAB_MODEL, whole_number

EXAMPLES = """examples:
  python -m benchmarks.lateness
  python -m benchmarks.lateness --model models/resnet18 --only unprivileged

Exit codes: 0 no worse than a loaded machine explains, 1 otherwise, 2 refused."""

DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "models"
NETWORK, LABELS = DATA / "mobilenetv2_fp32_dequant.onnx", DATA / "imagenet_classes.txt"
AIMS_MS = {"unprivileged": 25.0, "real time": 10.0}
FULL = 0.95
"""Whoever leaves more of the processors unused makes nobody late."""

HEADER = (
    "scheduling",
    "aim, p99",
    "p50",
    "p99",
    "worst",
    "cycles",
    "processors",
    "vision has",
    "it looks",
    "inference",
    "",
)


def main(argv: Sequence[str] | None = None) -> int:
    parser = _parser()
    args = parser.parse_args(argv)
    found: Dict[str, Load] = {}
    with ended_by_signals(1), tempfile.TemporaryDirectory() as folder:
        try:
            model = args.model or _real_model(Path(folder) / "model")
            for name in args.only:
                wrapper = unprivileged() if name == "unprivileged" else ()
                print(f"{name}: {args.seconds} s ...", file=sys.stderr, flush=True)
                setup = RobotSetup(model, threads=args.threads)
                found[name] = loaded(setup, Path(folder) / name.replace(" ", "-"), wrapper, args.seconds)
        except RefusedError as error:
            parser.exit(2, f"{parser.prog}: {error}\n")
        except UnreachableError as error:
            parser.exit(1, f"{parser.prog}: {error}\n")
    table = markdown(HEADER, [cells(name, load) for name, load in found.items()])
    print(table)
    records: List[Dict[str, Any]] = [{"scheduling": name, **asdict(load)} for name, load in found.items()]
    print(f"written to {write_results(args.out, 'lateness', records, table)}", file=sys.stderr)
    return int(any(is_broken(name, load) for name, load in found.items()))


def is_broken(name: str, load: Load) -> bool:
    """Whether it is later than the load of a machine explains. Real time that was not given is not judged."""
    given = name != "real time" or load.real_time > 0
    return given and load.p99 > ALLOWED * AIMS_MS[name]


def cells(name: str, load: Load) -> List[str]:
    """A line of the table."""
    aim_ms = AIMS_MS[name]
    word = "met" if load.p99 < aim_ms else "broken" if is_broken(name, load) else "missed"
    if name == "real time" and not load.real_time:
        word = "not allowed here"
    if load.busy < FULL:
        word += ", but the processors were not full: a larger --model"
    figures = load.figures
    times = (f"{value:.1f} ms" for value in (aim_ms, load.p50, load.p99, load.worst))
    vision = f"{load.cores['vision']:.2f} cores" if "vision" in load.cores else "died"
    rate, infer = f"{figures.get('frames [Hz]', '-')} a second", f"{figures.get('infer [ms]', '-')} ms"
    return [name, *times, str(load.cycles), f"{100 * load.busy:.0f} % busy", vision, rate, infer, word]


def _real_model(folder: Path) -> Path:
    """MobileNetV2 where it is beside the project, else what ships."""
    if not NETWORK.is_file():
        print(f"{NETWORK.name} is not on this machine: the simulator's own model instead", file=sys.stderr)
        return LAB_MODEL
    made = make_model_folder(
        NETWORK, read_labels(LABELS), folder, name=NETWORK.stem, origin="unknown", licence="unknown"
    )
    return made.path


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.lateness",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--model", type=Path, help="model folder (default: MobileNetV2 where it is there, else the simulator's own)")
    add("--threads", type=whole_number(0, 64), default=0, metavar="N", help="of the network; 0: one a core (default)")
    add("--seconds", type=whole_number(1, 86400), default=round(WINDOW_S), metavar="S", help="default: 62")
    add("--only", nargs="+", choices=list(AIMS_MS), default=list(AIMS_MS), metavar="HOW", help=", ".join(AIMS_MS))
    add("--out", type=Path, default=Path("out/lateness"), metavar="DIR", help="default: out/lateness")
    return parser


if __name__ == "__main__":
    sys.exit(main())
