# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion evaluate`: how well objects are found, named, boxed and measured, on simulated worlds with truth."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from edgefusion.tools.arguments import LAB_MODEL, seed_number, whole_number

if TYPE_CHECKING:
    from edgefusion.config import PerceptionConfig
    from edgefusion.perception.calibration import Calibration
    from edgefusion.perception.detector import Detector

EXAMPLES = """examples:
  edgefusion evaluate
  edgefusion evaluate --frames 2000 --out out/figures
  edgefusion evaluate --worlds laboratory office my_world.toml --model models/mine
  edgefusion evaluate --frames 100 --json

DIR gets figures.json, figures.md, plots as PNG and, in failures/, pictures of what went wrong.
Worlds are named as they ship, or files; `random` stands for worlds by seed, none of which the shipped model has seen.
Exit codes: 0 done, 1 failed while running, 2 refused input, 130 interrupted."""

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
    worlds_help = "random, laboratory, office, street, storeroom, or TOML files (default: random)"
    add("--worlds", nargs="+", default=["random"], metavar="WORLD", help=worlds_help)
    add("--frames", type=whole_number(1, 1_000_000), default=500, metavar="N", help="in all worlds (default: 500)")
    add("--model", type=Path, default=LAB_MODEL, help="model folder (default: the simulator's own)")
    add("--config", type=Path, help="TOML file with [perception] settings instead of the defaults")
    add("--seed", type=seed_number, default=0, metavar="N", help="of worlds, places and noise (default: 0)")
    add("--threads", type=whole_number(0, 1024), default=0, metavar="N", help="of the network (default: all cores)")
    add("--out", type=Path, metavar="DIR", help="folder for the results (default: out/evaluation)")
    add("--overwrite", action="store_true", help="replace the results in DIR")
    add("--json", action="store_true", help="print the figures as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Measures, writes the table and the plots, prints the table. Raises RefusedError."""
    import sys

    from tqdm import tqdm

    from edgefusion.config import load_config
    from edgefusion.sim.renderer import Renderer
    from edgefusion.sim.rig import Rig
    from edgefusion.tools.evaluation import evaluate, looks, named_worlds
    from edgefusion.tools.evaluation_report import EvaluationFolder
    from edgefusion.tools.figures import summary
    from edgefusion.tools.geometry import calibration_of
    from edgefusion.tools.look_pictures import LookPictures
    from edgefusion.tools.report_plots import check_matplotlib
    from edgefusion.tools.results import results_path

    check_matplotlib()
    rig, config = Rig(), load_config(args.config).perception
    calibration = calibration_of(rig)
    worlds = named_worlds(args.worlds)
    detectors = _detectors(args, calibration, config)
    pictures = LookPictures(calibration, config)
    folder = EvaluationFolder(results_path(args.out, "evaluation", args.overwrite), args.overwrite, pictures)
    with Renderer(rig) as renderer:
        frames = looks(worlds, args.frames, args.seed, rig, renderer)
        progress = tqdm(frames, total=args.frames, unit="frame", disable=None, file=sys.stderr)
        outcomes = evaluate(progress, detectors, calibration, folder.keep_failures(DEFAULTS))
    report = {
        "version": 1,
        "worlds": args.worlds,
        "frames": args.frames,
        "seed": args.seed,
        "model": str(args.model),
        "config": None if args.config is None else str(args.config),
        "settings": {name: summary(outcome) for name, outcome in outcomes.items()},
    }
    table = folder.write(report, outcomes)
    print(folder.json(report) if args.json else f"{table}\nwritten to {folder.path}")
    return 0


def _detectors(args: argparse.Namespace, calibration: Calibration, config: PerceptionConfig) -> dict[str, Detector]:
    from edgefusion.config import PerceptionConfig
    from edgefusion.perception.classifier import open_classifier
    from edgefusion.perception.detector import Detector
    from edgefusion.perception.network import RuntimeOptions

    options = RuntimeOptions(threads=args.threads)
    paper = PerceptionConfig(
        features="yr",
        objects=1,
        distance="minimum",
        heights=(0.6, 1.0, 1.6),
        split=False,
        max_object_width_m=100.0,
        max_flush_width_m=100.0,
    )
    return {
        DEFAULTS: Detector(open_classifier(args.model, options=options), calibration, config),
        PAPER: Detector(open_classifier(args.model, options=options, fit="squash"), calibration, paper),
    }
