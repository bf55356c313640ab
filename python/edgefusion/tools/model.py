# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion model`: makes, checks and shows model folders.

Each command raises RefusedError for what it refuses; the heavy modules are imported where they are needed.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from edgefusion.perception.model_folder import ModelFolder
    from edgefusion.perception.preprocessing import Preprocessing

# As in perception.preprocessing and perception.onnx_header, which `--help` need not import.
FITS = ("squash", "letterbox", "square-context", "shorter-side+centre")
FILTERS = ("antialias", "linear")
PRECISIONS = ("fp32", "fp16", "int8")

EXAMPLES = """\
examples:
  edgefusion model add mobilenet.onnx --labels imagenet.txt --licence Apache-2.0
      makes the folder ./mobilenet, with the usual preprocessing of ImageNet's networks
  edgefusion model add resnet.onnx --labels imagenet.txt --size 224 --fit shorter-side+centre
      one that was trained with torchvision's
  edgefusion model check mobilenet
      nothing was changed, and it answers here as it did where it was made
  edgefusion model show mobilenet --json

Exit status: 0 done, 2 refused; the last line says why.
"""


def add_parser(subparsers: Any) -> None:
    """Adds the verb `model` to the command line; each command sets `run`, which takes the arguments."""
    parser = subparsers.add_parser(
        "model",
        help="make, check and show model folders",
        description="Makes, checks and shows model folders: a network, its labels and what vouches for them.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="model_command", required=True, metavar="COMMAND")
    _add_add(commands)
    check = commands.add_parser("check", help="load a model folder and compare its golden answer")
    check.add_argument("folder", type=Path, metavar="FOLDER")
    check.set_defaults(run=run_check)
    show = commands.add_parser("show", help="print what a model folder says of itself")
    show.add_argument("folder", type=Path, metavar="FOLDER")
    show.add_argument("--json", action="store_true", help="the manifest and the labels, for a program")
    show.set_defaults(run=run_show)


def _add_add(commands: Any) -> None:
    parser = commands.add_parser(
        "add",
        help="make a model folder of an ONNX file",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("file", type=Path, metavar="FILE", help="the network: float32 [n, 3, height, width] to [n, classes]")
    add("--labels", type=Path, required=True, help="one class a line, in the order of the outputs")
    add("--out", type=Path, help="the folder to make; it must not exist (default: the file's name, here)")
    add("--name", help="default: the file's")
    add("--origin", default="unknown", help="where the network comes from (default: %(default)s)")
    add("--licence", default="unknown", help="of the network (default: %(default)s)")
    add("--size", type=int, help="side of the input, pixels (default: what it is fixed to, else 256)")
    add(
        "--fit",
        choices=FITS,
        default="letterbox",
        help="how a box becomes a square (default: %(default)s; the paper: squash)",
    )
    add("--filter", choices=FILTERS, default="antialias", help="how it is resized (default: %(default)s)")
    add("--mean", type=float, nargs=3, metavar=("R", "G", "B"), help="of values 0..1 (default: ImageNet's)")
    add("--std", type=float, nargs=3, metavar=("R", "G", "B"), help="of values 0..1 (default: ImageNet's)")
    add("--crop-fraction", type=float, help="for shorter-side+centre (default there: 0.875, torchvision's)")
    softmax = parser.add_mutually_exclusive_group()
    softmax.add_argument("--softmax", action="store_true", default=None, help="default: found out")
    softmax.add_argument("--no-softmax", action="store_false", dest="softmax", help="they are probabilities")
    add("--precision", choices=PRECISIONS, help="of the network; sets the tolerance (default: found out)")
    add("--golden", type=Path, help="a picture that the network knows (default: a made-up one)")
    parser.set_defaults(run=run_add)


def run_add(args: argparse.Namespace) -> int:
    """Makes a model folder of an ONNX file."""
    from edgefusion.perception.make_model import make_model_folder
    from edgefusion.perception.model_folder import read_labels

    folder = make_model_folder(
        args.file,
        read_labels(args.labels),
        args.out or Path(args.file.stem),
        name=args.name or args.file.stem,
        origin=args.origin,
        licence=args.licence,
        preprocessing=_preprocessing(args),
        softmax=args.softmax,
        precision=args.precision,
        golden=args.golden,
    )
    print(_summary(folder))
    return 0


def run_check(args: argparse.Namespace) -> int:
    """Loads a model folder as a robot would and says how near its answer is to the golden one."""
    from edgefusion.perception.classifier import open_classifier
    from edgefusion.perception.model_folder import load_model_folder

    folder = load_model_folder(args.folder)
    classifier = open_classifier(args.folder)
    answer, tolerance = folder.manifest.golden, folder.golden.tolerance
    print(f"{args.folder}: nothing was changed, {len(folder.labels)} labels")
    print(
        f"golden answer on {classifier.provider}: {folder.labels[answer.classes[0]]}, "
        f"largest difference {classifier.golden_difference:.2g}, permitted {tolerance:g}"
    )
    if classifier.provider_note:
        print(classifier.provider_note)
    return 0


def run_show(args: argparse.Namespace) -> int:
    """Prints the manifest of a model folder whose files are intact; needs no runtime."""
    import msgspec

    from edgefusion.perception.model_folder import load_model_folder

    folder = load_model_folder(args.folder)
    if args.json:
        shown = {**msgspec.to_builtins(folder.manifest), "labels": folder.labels}
        print(msgspec.json.format(msgspec.json.encode(shown)).decode())
    else:
        print(_summary(folder))
    return 0


def _preprocessing(args: argparse.Namespace) -> Preprocessing:
    from edgefusion.perception.make_model import fixed_size
    from edgefusion.perception.preprocessing import DEFAULT, IMAGENET_MEAN, IMAGENET_STD, Preprocessing

    fraction = 0.875 if args.fit == "shorter-side+centre" else 1.0
    return Preprocessing(
        size=args.size if args.size is not None else fixed_size(args.file) or DEFAULT.size,
        fit=args.fit,
        filter=args.filter,
        mean=tuple(args.mean or IMAGENET_MEAN),
        std=tuple(args.std or IMAGENET_STD),
        crop_fraction=fraction if args.crop_fraction is None else args.crop_fraction,
    )


def _summary(folder: ModelFolder) -> str:
    from edgefusion.perception.onnx_header import read_onnx_header

    manifest, header = folder.manifest, read_onnx_header(folder.model)
    crop, answer = manifest.input, manifest.golden
    lines = {
        "folder": str(folder.path),
        "name": manifest.name,
        "origin": manifest.origin,
        "licence": manifest.licence,
        "network": f"{manifest.precision}, {len(folder.model) / 1e6:.1f} MB, "
        f"opset {header.opset}, IR version {header.ir_version}",
        "input": f"{crop.size} x {crop.size}, {crop.fit}, {crop.filter}",
        "labels": f"{len(folder.labels)}, softmax {'applied' if manifest.output.softmax else 'not needed'}",
        "golden": f"{folder.labels[answer.classes[0]]} {answer.probabilities[0]:.4f}",
    }
    return "\n".join(f"{name:8} {text}" for name, text in lines.items())
