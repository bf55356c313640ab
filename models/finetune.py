# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Teaches a classifier one's own classes without training a network: `python models/finetune.py --help`.

The base stays as it is and says what it sees in each image, once; only its last layer is replaced, by one that is
fitted to the classes of the images. Both become one ONNX file in a model folder.
"""

from __future__ import annotations

import argparse
import functools
import json
import shlex
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from class_folders import FEWEST, LabelledImages, read_class_folders  # type: ignore[import-not-found] # beside it
from edgefusion.errors import RefusedError
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import Training, kind_of
from edgefusion.perception.network import one_line
from edgefusion.tools.arguments import seed_number
from frozen_base import BATCH, Base, open_base, outputs_of  # type: ignore[import-not-found] # beside this file

TOLERANCE = 1e-3
EXAMPLES = f"""\
examples:
  python models/finetune.py photos --out models/mine
      photos/mug/*.jpg, photos/drill/*.jpg, ...: the folders' names are the classes; the base is models/resnet18,
      which python models/export.py --out models/resnet18 makes
  python models/finetune.py photos --base models/small --out models/mine
      another base: a model folder, whose preprocessing is kept
  python models/finetune.py photos --base mobilenetv2.onnx --out models/mine --json > report.json
      a bare file, which gets the usual preprocessing; the report for a program, all else on stderr

A class needs {FEWEST} images; 30 are better, and about as many of each class. A fifth of each is held out, for the
accuracy and the confusion table; what is written is then fitted to all of them. Where images look alike, as the
frames of a video do, the accuracy promises too much.

The JSON: labels; images of each; accuracy and confusion (rows the truth, columns what it said) of what is held out;
C, the inverse strength of the regularization; seconds; bytes of the folder.

Exit status: 0 fitted and checked, 2 refused; the last line says why.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(arguments)
    say = functools.partial(print, file=sys.stderr if args.json else sys.stdout)
    command = shlex.join(["python", "models/finetune.py", *(sys.argv[1:] if arguments is None else arguments)])
    try:
        report = finetune(args, command, say)
    except RefusedError as error:
        print(error, file=sys.stderr)
        return 2
    if args.json:
        print(json.dumps(report))
    return 0


def finetune(args: argparse.Namespace, command: str, say: Callable[[str], None]) -> dict[str, Any]:
    """From the arguments to the folder, a line of progress a step. Returns the report. Raises RefusedError."""
    if kind_of(args.out) != "nothing":
        raise RefusedError(f"{args.out}: expected a folder that is not there yet, got one that is")
    surgery, heads = _import_tools()
    base = open_base(args.base)
    images = read_class_folders(args.images)
    body = surgery.body_of(base.model, base.output, str(base.path))
    say(f"{args.images}: {len(images.labels)} classes, {len(images.paths)} images")

    began = time.perf_counter()
    features = outputs_of(body.SerializeToString(), str(base.path), base.preprocessing, images.paths)
    features_s = time.perf_counter() - began
    say(f"{base.path}: {features.shape[1]} features of each image ({features_s:.1f} s)")

    began = time.perf_counter()
    held_out = heads.hold_out(features, images.classes, args.seed)
    head = heads.fit_head(features, images.classes, held_out.strength)
    head_s = time.perf_counter() - began
    for line in _describe(held_out, images, head_s):
        say(line)

    fused = surgery.with_head(body, head.weights, head.bias, base.output, str(base.path)).SerializeToString()
    difference = _compare(fused, base, images, head.logits(features[:BATCH]))
    say(f"one file: agrees with its two parts, largest difference {difference:.2g}, permitted {TOLERANCE:g}")
    _write(args, base, fused, images, held_out, command)
    size = sum(file.stat().st_size for file in args.out.iterdir())
    say(f"{args.out}: {size / 1e6:.1f} MB")
    return {**_report(held_out, images), "features_s": features_s, "head_s": head_s, "bytes": size}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add(
        "images",
        type=Path,
        metavar="FOLDER",
        help="of images, one folder per class; one called background stands for all that is none of them",
    )
    add("--out", type=Path, required=True, help="the model folder to make; it must not exist")
    add(
        "--base",
        type=Path,
        default=Path("models/resnet18"),
        help="a model folder or a bare .onnx file (default: %(default)s)",
    )
    add("--seed", type=seed_number, default=0, metavar="N", help="of what is held out (default: %(default)s)")
    add("--name", help="default: that of the folder that is made")
    add("--licence", help="of the weights (default: the base's)")
    add("--golden", type=Path, help="a picture that the network knows; default: a made-up one")
    add("--json", action="store_true", help="the report as JSON on stdout, all else on stderr")
    return parser


def _import_tools() -> tuple[Any, Any]:
    try:
        import linear_head  # type: ignore[import-not-found] # beside this file
        import onnx_surgery  # type: ignore[import-not-found] # beside this file

        return onnx_surgery, linear_head
    except ImportError as error:
        expected = "expected onnx and scikit-learn (pip install 'edgefusion[cpu,finetune]')"
        raise RefusedError(f"finetune: {expected}, got: {one_line(error)}") from error


def _describe(held_out: Any, images: LabelledImages, seconds: float) -> Iterator[str]:
    """The accuracy, the confusion table, and what was not measured."""
    total = len(images.paths)
    right, asked = np.trace(held_out.confusion), held_out.confusion.sum()
    share = f"{right} of {asked} images named right ({held_out.accuracy:.3f})"
    yield f"held out: {share} by a head fitted to the other {total - asked}"
    yield "rows: the truth; columns: what it said"
    width = max(map(len, images.labels))
    yield " " * (width + 5) + "".join(f"{column:5}" for column in range(1, len(images.labels) + 1))
    for number, (label, row) in enumerate(zip(images.labels, held_out.confusion), 1):
        yield f"{number:4} {label:{width}}" + "".join(f"{count or '.':>5}" for count in row)
    yield f"written: a head fitted to all {total} images with the same C = {held_out.strength:g} ({seconds:.1f} s);"
    yield "         the accuracy above is not its own, but that of the head with fewer images"


def _report(held_out: Any, images: LabelledImages) -> dict[str, Any]:
    return {
        "labels": images.labels,
        "images": np.bincount(images.classes).tolist(),
        "accuracy": held_out.accuracy,
        "confusion": held_out.confusion.tolist(),
        "C": held_out.strength,
    }


def _compare(fused: bytes, base: Base, images: LabelledImages, expected: npt.NDArray[np.float32]) -> float:
    """The largest difference to the outputs of the two parts, relative to large ones. Raises RefusedError."""
    got = outputs_of(fused, str(base.path), base.preprocessing, images.paths[: len(expected)])
    difference = float(np.abs(got - expected).max() / max(1.0, np.abs(expected).max()))
    if not difference <= TOLERANCE:
        both = f"expected one file to answer as its two parts do within {TOLERANCE:g}"
        raise RefusedError(f"{base.path}: {both}, got a difference of {difference:.2g}")
    return difference


def _write(
    args: argparse.Namespace, base: Base, fused: bytes, images: LabelledImages, held_out: Any, command: str
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        onnx_file = Path(folder) / f"{args.out.name}.onnx"
        onnx_file.write_bytes(fused)
        make_model_folder(
            onnx_file,
            images.labels,
            args.out,
            name=args.name or args.out.name,
            origin=f"{base.name} ({base.origin}), its last layer fitted to {len(images.paths)} images",
            licence=args.licence or base.licence,
            preprocessing=base.preprocessing,
            softmax=True,
            golden=args.golden,
            training=Training(
                command=command,
                seed=args.seed,
                accuracy=round(held_out.accuracy, 4),
                held_out=f"{held_out.confusion.sum()} of the images, by a head fitted to the others only",
            ),
        )


if __name__ == "__main__":
    sys.exit(main())
