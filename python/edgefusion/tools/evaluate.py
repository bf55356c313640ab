# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion evaluate`: how well objects are found, named, boxed and measured, on simulated worlds with truth."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from edgefusion.perception.detector import Detector
    from edgefusion.sim.rig import Rig

EXAMPLES = """examples:
  edgefusion evaluate
  edgefusion evaluate --frames 2000 --out out/figures
  edgefusion evaluate --worlds laboratory office my_world.toml --model models/mine
  edgefusion evaluate --frames 100 --json

DIR gets figures.json, figures.md, plots as PNG and, in failures/, pictures of what went wrong.
Worlds are named as they ship, or files; `random` stands for worlds by seed, none of which the shipped model has seen.
Exit codes: 0 done, 1 failed while running, 2 refused input, 130 interrupted."""

MODEL = Path(__file__).resolve().parents[1] / "data" / "lab-model"
DEFAULTS, PAPER = "edgefusion", "the paper's settings"


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "evaluate",
        help="figures of the detector on simulated worlds with ground truth",
        description="Measures the detector on simulated worlds, its defaults beside the paper's settings.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--worlds", nargs="+", default=["random"], metavar="WORLD", help="default: random")
    add("--frames", type=_count, default=500, metavar="N", help="how many, in all worlds together (default: 500)")
    add("--model", type=Path, default=MODEL, help="model folder (default: the simulator's own)")
    add("--config", type=Path, help="TOML file with [perception] settings instead of the defaults")
    add("--seed", type=int, default=0, help="of worlds, places and noise (default: 0)")
    add("--threads", type=int, default=0, help="of the network (default: all cores)")
    add("--out", type=Path, metavar="DIR", help="folder for the results (default: out/evaluation)")
    add("--overwrite", action="store_true", help="replace the results in DIR")
    add("--json", action="store_true", help="print the figures as JSON")
    parser.set_defaults(run=run)


def _count(text: str) -> int:
    if not (text.isdecimal() and 1 <= int(text) <= 1_000_000):
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 to 1000000, got {text!r}")
    return int(text)


def run(args: argparse.Namespace) -> int:
    """Measures, writes the table and the plots, prints the table. Raises RefusedError."""
    import sys

    from tqdm import tqdm

    from edgefusion.sim.renderer import Renderer
    from edgefusion.sim.rig import Rig
    from edgefusion.tools.evaluation import evaluate, looks
    from edgefusion.tools.evaluation_report import EvaluationFolder
    from edgefusion.tools.figures import summary
    from edgefusion.tools.geometry import calibration_of
    from edgefusion.tools.results import results_path

    rig = Rig()
    calibration = calibration_of(rig)
    detectors = _detectors(args, rig)
    folder = EvaluationFolder(results_path(args.out, "evaluation", args.overwrite), args.overwrite, calibration)
    with Renderer(rig) as renderer:
        frames = looks(args.worlds, args.frames, args.seed, rig, renderer)
        progress = tqdm(frames, total=args.frames, unit="frame", disable=None, file=sys.stderr)
        outcomes = evaluate(progress, detectors, calibration, folder.keep_failures(DEFAULTS))
    report = {
        "worlds": args.worlds,
        "frames": args.frames,
        "seed": args.seed,
        "model": str(args.model),
        "settings": {name: summary(outcome) for name, outcome in outcomes.items()},
    }
    table = folder.write(report, outcomes)
    print(folder.json(report) if args.json else f"{table}\nwritten to {folder.path}")
    return 0


def _detectors(args: argparse.Namespace, rig: Rig) -> dict[str, Detector]:
    from edgefusion.config import PerceptionConfig, load_config
    from edgefusion.perception.classifier import open_classifier
    from edgefusion.perception.detector import Detector
    from edgefusion.perception.network import RuntimeOptions
    from edgefusion.tools.geometry import calibration_of

    calibration = calibration_of(rig)
    options = RuntimeOptions(threads=args.threads)
    paper = PerceptionConfig(
        features="yr", objects=1, distance="minimum", heights=(0.6, 1.0, 1.6), split=False, max_object_width_m=100.0
    )
    return {
        DEFAULTS: Detector(
            open_classifier(args.model, options=options), calibration, load_config(args.config).perception
        ),
        PAPER: Detector(open_classifier(args.model, options=options, fit="squash"), calibration, paper),
    }
