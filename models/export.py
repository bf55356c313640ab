# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Exports a classifier of torchvision as a model folder: `python models/export.py --help`."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any, Sequence, get_args

import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.perception.golden import golden_picture
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import read_labels
from edgefusion.perception.network import one_line
from edgefusion.perception.preprocessing import IMAGENET_MEAN, IMAGENET_STD, Filter, Fit, Preprocessing, whole
from to_onnx import TOLERANCE, compare, describe, export_onnx  # type: ignore[import-not-found] # beside this file

EXAMPLES = """\
examples:
  python models/export.py --out models/resnet18
      ResNet18 with torchvision's ImageNet weights, which it downloads
  python models/export.py --weights mine.pth --labels mine.txt --out models/mine
      a ResNet18 that was fine-tuned
  python models/export.py --arch shufflenet_v2_x0_5 --random --labels labels.txt --size 128 --out models/tiny
      a small network that knows nothing, for tests and demonstrations

Exit status: 0 exported and checked, 2 refused; the last line says why.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(arguments)
    try:
        export(args)
    except RefusedError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def export(args: argparse.Namespace) -> None:
    """From the arguments to the folder, a line of progress a step. Raises RefusedError."""
    if args.out.exists():
        raise RefusedError(f"{args.out}: expected a folder that is not there yet, got one that is")
    preprocessing = _preprocessing(args)
    torch, torchvision = _import_torch()
    model, labels, origin = _build(torch, torchvision, args)
    if args.random:
        _enliven(torch, model, preprocessing)
    print(f"{args.arch}: {len(labels)} classes, {origin}")

    with tempfile.TemporaryDirectory() as folder:
        onnx_file = Path(folder) / f"{args.arch}.onnx"
        export_onnx(torch, model, onnx_file, args.size, args.fixed_size)
        print(describe(onnx_file))
        difference = compare(torch, model, onnx_file, args.size, args.fixed_size)
        print(f"agrees with torch: largest difference of an output {difference:.2g}, permitted {TOLERANCE:g}")
        made = make_model_folder(
            onnx_file,
            labels,
            args.out,
            name=args.name or args.arch,
            origin=origin,
            licence=args.licence or ("unknown" if args.weights else "BSD-3-Clause"),
            preprocessing=preprocessing,
            golden=args.golden,
        )
    answer = made.manifest.golden
    print(f"golden answer: {labels[answer.classes[0]]} ({answer.probabilities[0]:.4f})")
    print(f"{args.out}: {sum(file.stat().st_size for file in args.out.iterdir()) / 1e6:.1f} MB")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--out", type=Path, required=True, help="the model folder to make; it must not exist")
    add(
        "--arch",
        default="resnet18",
        help="any classifier of torchvision, by its function's name (default: %(default)s)",
    )
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--weights", type=Path, help="a state dict (.pth); default: torchvision's, downloaded")
    source.add_argument("--random", action="store_true", help="no training at all: for tests")
    add("--seed", type=int, default=0, help="of --random (default: %(default)s)")
    add("--labels", type=Path, help="one class a line, in the order of the outputs; default: torchvision's")
    add("--name", help="default: the architecture's")
    add("--licence", help="of the weights (default: torchvision's, BSD-3-Clause; unknown with --weights)")
    add("--golden", type=Path, help="a picture that the network knows; default: a made-up one")
    add(
        "--fixed-size",
        action="store_true",
        help="for networks that cannot take images of any size, as VGG",
    )
    add("--size", type=int, default=256, help="side of the input, pixels (default: %(default)s)")
    add(
        "--fit",
        choices=get_args(Fit),
        default="letterbox",
        help="how a box becomes a square (default: %(default)s; the paper: squash)",
    )
    add(
        "--filter",
        choices=get_args(Filter),
        default="antialias",
        help="how it is resized (default: %(default)s)",
    )
    add("--crop-fraction", type=float, default=1.0, help="for shorter-side+centre; torchvision's is 0.875")
    return parser


def _preprocessing(args: argparse.Namespace) -> Preprocessing:
    return Preprocessing(
        size=args.size,
        fit=args.fit,
        filter=args.filter,
        mean=IMAGENET_MEAN,
        std=IMAGENET_STD,
        crop_fraction=args.crop_fraction,
    )


def _import_torch() -> tuple[Any, Any]:
    try:
        import onnx  # noqa: F401 (torch's exporter needs it, and would say so only at its end)
        import torch

        from torchvision_cpu import import_torchvision  # type: ignore[import-not-found] # beside this file

        return torch, import_torchvision()
    except (ImportError, RuntimeError) as error:
        expected = "expected torch, torchvision and onnx (pip install 'edgefusion[cpu,export]')"
        raise RefusedError(f"export: {expected}, got: {one_line(error)}") from error


def _build(torch: Any, torchvision: Any, args: argparse.Namespace) -> tuple[Any, Sequence[str], str]:
    """The network ready to run, its labels, and where it comes from."""
    models, version = torchvision.models, f"torchvision {torchvision.__version__.split('+')[0]}"
    if args.arch not in models.list_models(module=models):
        raise RefusedError(f"--arch: expected a classifier of {version}, got {args.arch}")
    weights = models.get_model_weights(args.arch).DEFAULT
    labels = read_labels(args.labels) if args.labels else weights.meta["categories"]
    torch.manual_seed(args.seed)
    if args.random:
        model = models.get_model(args.arch, weights=None, num_classes=len(labels))
        return model.eval(), labels, f"{version}, random weights, seed {args.seed}"
    if args.weights:
        model = models.get_model(args.arch, weights=None, num_classes=len(labels))
        _load(torch, model, args.weights)
        return model.eval(), labels, f"{version}, weights of {args.weights.name}"
    known = len(weights.meta["categories"])
    if len(labels) != known:
        raise RefusedError(f"{args.labels}: expected {known} labels for {weights}, got {len(labels)}")
    return _download(models, args.arch, weights).eval(), labels, f"{version}, {weights}"


def _download(models: Any, arch: str, weights: Any) -> Any:
    try:
        return models.get_model(arch, weights=weights)
    except (OSError, RuntimeError) as error:  # no network, or a download that broke off
        hint = "--weights FILE takes them from a file, --random needs none"
        raise RefusedError(f"{weights.url}: expected the weights, got: {one_line(error)}; {hint}") from error


def _load(torch: Any, model: Any, path: Path) -> None:
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
        for wrapper in ("model", "state_dict"):  # as training scripts save them
            state = state.get(wrapper, state)
        model.load_state_dict(state)
    except Exception as error:
        raise RefusedError(f"{path}: expected weights for this network, got: {one_line(error)[:300]}") from error


def _enliven(torch: Any, model: Any, preprocessing: Preprocessing) -> None:
    """Gives an untrained network answers that differ clearly from picture to picture.

    Fresh weights alone answer nearly the same to everything, and no golden answer could tell two such
    networks apart: the batch norms learn their statistics from made-up pictures, the last layer is scaled.
    """
    size = preprocessing.size
    pictures = [golden_picture(1000 + seed, size) for seed in range(16)]
    batch = torch.from_numpy(np.concatenate([preprocessing.apply(p, whole(p)) for p in pictures]))
    norms = [m for m in model.modules() if isinstance(m, torch.nn.modules.batchnorm._BatchNorm)]
    kinds = (torch.nn.Linear, torch.nn.Conv2d)
    last = [m for m in model.modules() if isinstance(m, kinds)][-1]
    with torch.no_grad():
        for norm in norms:
            norm.train()
            norm.momentum = None  # the plain mean over what it sees
        model(batch)
        model.eval()
        outputs = model(batch)
        scale = 2 / max(float((outputs - outputs.mean(0)).std()), 1e-12)
        last.weight *= scale
        if last.bias is not None:
            last.bias -= outputs.mean(0)
            last.bias *= scale


if __name__ == "__main__":
    sys.exit(main())
