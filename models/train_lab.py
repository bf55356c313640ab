# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Trains the classifier of the simulator's kinds and writes it as a model folder: `python models/train_lab.py --help`.

It is taught to be sure of a name only where the box fits the object: then the paper's rule, the box that gave the
winner its highest probability, finds the height that the laser cannot see.
"""

from __future__ import annotations

import argparse
import shlex
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Sequence

from tqdm import tqdm

from edgefusion.errors import RefusedError
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import Boxes, Training
from edgefusion.perception.preprocessing import IMAGENET_MEAN, IMAGENET_STD, Preprocessing
from edgefusion.tools.arguments import whole_number
from lab_crops import Crops, class_names, joined, render_crops  # type: ignore[import-not-found] # beside this file
from lab_training import GOOD_FIT, accuracy, fit  # type: ignore[import-not-found] # beside this file
from to_onnx import compare, describe, export_onnx  # type: ignore[import-not-found] # beside this file

HEIGHTS_M = tuple(round(0.45 * 1.2**i, 3) for i in range(11))
"""From a low heater to a pillar; with steps of a fifth the nearest height is at most a tenth off."""

SEEDS, HELD_OUT = 10_000, 1_000_000
"""Worlds that a seed of this script may take, the next ones are the next seed's, and the first that is never trained on
but measured on; `edgefusion evaluate` begins at twice that."""

LARGEST_MB = 2.0

NUMBERS = (
    ("worlds", 1, SEEDS, 360, "random worlds to train on"),
    ("held-out", 1, SEEDS, 40, "further worlds that measure the accuracy"),
    ("views", 1, 1000, 8, "places in each world to look from"),
    ("epochs", 1, 1000, 16, "passes over all crops"),
    ("size", 32, 1024, 96, "side of the network's input, a multiple of 32"),
    ("seed", 0, 99, 0, "of worlds, weights and order"),
    ("threads", 1, 1024, 2, "of torch; the result depends on it in the last digits"),
)
"""The options: name, least, most, default, what for."""

EXAMPLES = """\
examples:
  python models/train_lab.py --out models/lab
      about twenty minutes on two cores: a third of it renders the crops
  python models/train_lab.py --out models/quick --worlds 20 --views 4 --epochs 2
      a quick try

Exit status: 0 trained and checked, 2 refused; the last line says why.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(arguments)
    try:
        train(args)
    except RefusedError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--out", type=Path, required=True, help="the model folder to make; it must not exist")
    for name, least, most, default, what in NUMBERS:
        about = f"{what} (default: {default})"
        add(f"--{name}", type=whole_number(least, most), default=default, metavar="N", help=about)
    return parser


def train(args: argparse.Namespace) -> None:
    """From the arguments to the folder, a line of progress a step. Raises RefusedError."""
    if args.out.exists():
        raise RefusedError(f"{args.out}: expected a folder that is not there yet, got one that is")
    if args.size % 32:
        raise RefusedError(f"--size: expected a multiple of 32, got {args.size}")
    torch = _import_torch()
    torch.set_num_threads(args.threads)
    begin_s = time.monotonic()
    preprocessing = Preprocessing(
        size=args.size, fit="letterbox", filter="antialias", mean=IMAGENET_MEAN, std=IMAGENET_STD, crop_fraction=1.0
    )
    names, first = class_names(), args.seed * SEEDS
    known = _render("crops", range(first, first + args.worlds), args.views, preprocessing)
    held_out = _render("held out", range(HELD_OUT + first, HELD_OUT + first + args.held_out), args.views, preprocessing)
    print(f"{len(known)} crops of {len(names)} classes, {len(held_out)} held out; {_since(begin_s)}")
    network = fit(torch, known, len(names), args.size, args.epochs, args.seed)
    share = accuracy(torch, network, held_out)
    print(f"names {share:.4f} of the held-out crops whose box fits; {_since(begin_s)}")
    _write(torch, network, names, preprocessing, share, args)
    print(f"{args.out}: {sum(file.stat().st_size for file in args.out.iterdir()) / 1e6:.2f} MB; {_since(begin_s)}")


def _since(begin_s: float) -> str:
    return f"{(time.monotonic() - begin_s) / 60:.1f} minutes"


def _import_torch() -> Any:
    try:
        import onnx  # noqa: F401 (torch's exporter needs it, and would say so only at its end)
        import torch
    except ImportError as error:
        raise RefusedError(f"train_lab: expected torch and onnx (the extra 'export'), got: {error}") from error
    return torch


def _render(what: str, worlds: range, views: int, preprocessing: Preprocessing) -> Crops:
    found = list(
        tqdm(
            render_crops(worlds, views, HEIGHTS_M, preprocessing),
            total=len(worlds),
            desc=what,
            unit="world",
            disable=None,
        )
    )
    if not found:
        raise RefusedError(f"{what}: expected at least one world with an object in view, got none")
    return joined(found)


def _write(
    torch: Any,
    network: Any,
    names: Sequence[str],
    preprocessing: Preprocessing,
    share: float,
    args: argparse.Namespace,
) -> None:
    command = "python models/train_lab.py " + shlex.join(
        f"--{name.replace('_', '-')}={value}" for name, value in sorted(vars(args).items()) if name != "out"
    )
    held_out = f"walls, and boxes with an IoU of {GOOD_FIT:g} or more, in {args.held_out} random worlds of other seeds"
    with tempfile.TemporaryDirectory() as folder:
        onnx_file = Path(folder) / "lab.onnx"
        export_onnx(torch, network, onnx_file, args.size, fixed_size=True)
        print(describe(onnx_file))
        print(f"agrees with torch: {compare(torch, network, onnx_file, args.size, True):.2g}")
        if onnx_file.stat().st_size > LARGEST_MB * 1e6:
            raise RefusedError(f"{onnx_file.name}: expected at most {LARGEST_MB} MB, got {onnx_file.stat().st_size}")
        make_model_folder(
            onnx_file,
            names,
            args.out,
            name="lab",
            origin="trained on rendered pictures of the simulator's kinds; knows nothing of the real world",
            licence="Apache-2.0",
            preprocessing=preprocessing,
            boxes=Boxes(heights=HEIGHTS_M, heights_in="metres", height_rule="sharpened"),
            training=Training(command=command, seed=args.seed, accuracy=round(share, 4), held_out=held_out),
        )


if __name__ == "__main__":
    sys.exit(main())
