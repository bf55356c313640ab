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

import numpy as np
import numpy.typing as npt
from tqdm import tqdm

from edgefusion.errors import RefusedError
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import Boxes, Training
from edgefusion.perception.preprocessing import IMAGENET_MEAN, IMAGENET_STD, Preprocessing
from lab_crops import Crops, class_names, joined, render_crops  # type: ignore[import-not-found] # beside this file
from to_onnx import compare, describe, export_onnx  # type: ignore[import-not-found] # beside this file

HEIGHTS_M = tuple(round(0.45 * 1.2**i, 3) for i in range(11))
"""From a low heater to a pillar; with steps of a fifth the nearest height is at most a tenth off."""

HELD_OUT = 1_000_000
"""Worlds of these seeds and above are never trained on; `edgefusion evaluate` begins at twice that."""

SURE, UNSURE = 0.9, 0.3
"""The IoU of a box with its object from which the network shall be certain, and down to which it shall doubt."""

DOUBT = 0.12
"""The probability that an object's name keeps in a box that does not fit at all."""

GOOD_FIT = 0.7
"""Boxes with less do not count in the accuracy."""

LARGEST_MB = 2.0
BATCH, LEARNING_RATE, WEIGHT_DECAY = 256, 4e-3, 0.02

EXAMPLES = """\
examples:
  python models/train_lab.py --out models/lab
      about half an hour on two cores: a third of it renders the crops
  python models/train_lab.py --out /tmp/lab --worlds 20 --views 4 --epochs 2
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
    add("--worlds", type=int, default=320, help="random worlds to train on (default: %(default)s)")
    add("--held-out", type=int, default=40, help="further worlds that measure the accuracy (default: %(default)s)")
    add("--views", type=int, default=8, help="places in each world to look from (default: %(default)s)")
    add("--epochs", type=int, default=14, help="passes over all crops (default: %(default)s)")
    add("--size", type=int, default=96, help="side of the network's input, a multiple of 32 (default: %(default)s)")
    add("--seed", type=int, default=0, help="of worlds, weights and order (default: %(default)s)")
    add("--threads", type=int, default=2, help="of torch; the result depends on it in the last digits")
    return parser


def train(args: argparse.Namespace) -> None:
    """From the arguments to the folder, a line of progress a step. Raises RefusedError."""
    if args.out.exists():
        raise RefusedError(f"{args.out}: expected a folder that is not there yet, got one that is")
    if args.size < 32 or args.size % 32:
        raise RefusedError(f"--size: expected a multiple of 32, got {args.size}")
    torch = _import_torch()
    torch.set_num_threads(args.threads)
    begin_s = time.monotonic()
    preprocessing = Preprocessing(
        size=args.size, fit="letterbox", filter="antialias", mean=IMAGENET_MEAN, std=IMAGENET_STD, crop_fraction=1.0
    )
    names, first = class_names(), args.seed * 10_000
    known = _render("crops", range(first, first + args.worlds), args.views, preprocessing)
    held_out = _render("held out", range(HELD_OUT + first, HELD_OUT + first + args.held_out), args.views, preprocessing)
    print(f"{len(known)} crops of {len(names)} classes, {len(held_out)} held out; {_since(begin_s)}")
    network = _fit(torch, known, len(names), args)
    accuracy = _accuracy(torch, network, held_out)
    print(f"names {accuracy:.4f} of the held-out crops whose box fits; {_since(begin_s)}")
    _write(torch, network, names, preprocessing, accuracy, args)
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


def targets(classes: npt.NDArray[np.int64], fits: npt.NDArray[np.float32], count: int) -> npt.NDArray[np.float32]:
    """What the network shall answer, float32[n, count]: a name as surely as the box fits, the rest spread evenly."""
    sure = np.clip((fits - UNSURE) / (SURE - UNSURE), 0, 1)
    named = DOUBT + (1 - DOUBT) * sure
    wanted = np.repeat(((1 - named) / (count - 1))[:, None], count, axis=1)
    wanted[np.arange(len(classes)), classes] = named
    return wanted.astype(np.float32)


def _fit(torch: Any, crops: Crops, count: int, args: argparse.Namespace) -> Any:
    from lab_network import LabNetwork  # type: ignore[import-not-found] # beside this file

    torch.manual_seed(args.seed)
    order = np.random.default_rng(args.seed)
    network = LabNetwork(count, args.size).to(memory_format=torch.channels_last)
    wanted = torch.from_numpy(targets(crops.classes, crops.fits, count))
    optimizer = torch.optim.AdamW(network.parameters(), lr=LEARNING_RATE, weight_decay=WEIGHT_DECAY)
    batches = max(1, len(crops) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, LEARNING_RATE, total_steps=args.epochs * batches)
    for epoch in range(args.epochs):
        network.train()
        shuffled, losses = order.permutation(len(crops)), []
        progress = tqdm(range(batches), desc=f"epoch {epoch + 1}/{args.epochs}", unit="batch", disable=None)
        for i in progress:
            chosen = shuffled[i * BATCH : (i + 1) * BATCH]
            batch = _augmented(torch, _normalized(torch, crops.pixels[chosen]), order)
            loss = torch.nn.functional.cross_entropy(network(batch), wanted[chosen])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            losses.append(loss.item())
            progress.set_postfix(loss=f"{np.mean(losses[-50:]):.3f}", refresh=False)
        print(f"epoch {epoch + 1}/{args.epochs}: loss {np.mean(losses):.4f}", flush=True)
    return network.eval()


def _normalized(torch: Any, pixels: npt.NDArray[np.uint8]) -> Any:
    """float32 [n, 3, size, size] as the detector's crops are."""
    mean, std = (torch.tensor(v).view(1, 3, 1, 1) for v in (IMAGENET_MEAN, IMAGENET_STD))
    batch = torch.from_numpy(pixels).permute(0, 3, 1, 2).float() / 255
    return ((batch - mean) / std).contiguous(memory_format=torch.channels_last)


def _augmented(torch: Any, batch: Any, rng: np.random.Generator) -> Any:
    """Mirrored by chance, brighter or darker, tinted."""
    n = len(batch)
    flipped = torch.from_numpy(rng.random(n) < 0.5).view(n, 1, 1, 1)
    batch = torch.where(flipped, batch.flip(3), batch)
    gain = torch.from_numpy(rng.normal(1, 0.1, (n, 1, 1, 1)).astype(np.float32))
    shift = torch.from_numpy(rng.normal(0, 0.08, (n, 3, 1, 1)).astype(np.float32))
    return torch.where(batch == 0, batch, batch * gain + shift)  # the padding stays what it is


def _accuracy(torch: Any, network: Any, crops: Crops) -> float:
    """The share of crops whose box fits that the network names."""
    chosen = np.flatnonzero(crops.fits >= GOOD_FIT)
    right = 0
    with torch.no_grad():
        for part in np.array_split(chosen, max(1, len(chosen) // BATCH)):
            answers = network(_normalized(torch, crops.pixels[part])).argmax(1).numpy()
            right += int((answers == crops.classes[part]).sum())
    return right / max(1, len(chosen))


def _write(
    torch: Any,
    network: Any,
    names: Sequence[str],
    preprocessing: Preprocessing,
    accuracy: float,
    args: argparse.Namespace,
) -> None:
    command = "python models/train_lab.py " + shlex.join(
        f"--{name.replace('_', '-')}={value}" for name, value in sorted(vars(args).items()) if name != "out"
    )
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
            boxes=Boxes(heights=HEIGHTS_M, heights_in="metres"),
            training=Training(
                command=command,
                seed=args.seed,
                accuracy=round(accuracy, 4),
                held_out=f"boxes with an IoU of {GOOD_FIT:g} or more in {args.held_out} random worlds of other seeds",
            ),
        )


if __name__ == "__main__":
    sys.exit(main())
