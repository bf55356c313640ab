# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The network that is built upon and stays as it is, and what it says to images."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import msgspec
import numpy as np
import numpy.typing as npt
from tqdm import tqdm

from edgefusion.errors import RefusedError
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.model_folder import kind_of, load_model_folder, read_file, read_picture
from edgefusion.perception.network import Network, RuntimeOptions, one_line
from edgefusion.perception.preprocessing import DEFAULT, Preprocessing, whole

BATCH = 16
_CPU = RuntimeOptions(provider="cpu")


@dataclass(frozen=True)
class Base:
    """A classifier to build upon. model: the ONNX file's bytes. output: the name of its output."""

    path: Path
    model: bytes
    name: str
    origin: str
    licence: str
    preprocessing: Preprocessing
    output: str


def open_base(path: Path) -> Base:
    """A model folder that answers here as it did where it was made, or a bare .onnx file, which gets DEFAULT.

    Raises RefusedError.
    """
    kind = kind_of(path)
    if kind == "nothing":
        hint = "python models/export.py --out models/resnet18 makes one"
        raise RefusedError(f"{path}: expected a base, a model folder or an ONNX file, got nothing; {hint}")
    if kind == "a file":
        model = read_file(path)
        network = Network(model, str(path), _CPU)
        preprocessing = msgspec.structs.replace(DEFAULT, size=network.size or DEFAULT.size)
        return Base(path, model, path.name, "origin unknown", "unknown", preprocessing, network.output_name)
    open_classifier(path, options=_CPU)  # asks for its golden answer
    folder = load_model_folder(path)
    made = folder.manifest
    preprocessing = Preprocessing(**{name: getattr(made.input, name) for name in Preprocessing.__struct_fields__})
    return Base(path, folder.model, made.name, made.origin, made.licence, preprocessing, made.output.name)


def outputs_of(
    model: bytes, source: str, preprocessing: Preprocessing, paths: Sequence[Path]
) -> npt.NDArray[np.float32]:
    """What a network says to whole images: float32[n, outputs]. Shows a progress bar on a terminal.

    source: what to call the network in a refusal. Raises RefusedError for an image that cannot be read, and for a
    network that fails or whose outputs are not finite.
    """
    network, rows = Network(model, source, _CPU), []
    with tqdm(total=len(paths), unit="image", disable=None, leave=False, file=sys.stderr) as bar:
        for start in range(0, len(paths), BATCH):
            pictures = [read_picture(path) for path in paths[start : start + BATCH]]
            batch = np.concatenate([preprocessing.apply(picture, whole(picture)) for picture in pictures])
            rows.append(_run(network, batch, source))
            bar.update(len(batch))
    outputs = np.concatenate(rows)
    finite = np.isfinite(outputs).all(axis=1)
    if not finite.all():
        raise RefusedError(f"{source}: expected finite numbers for {paths[int(finite.argmin())]}, got others")
    return outputs


def _run(network: Network, batch: npt.NDArray[np.float32], source: str) -> npt.NDArray[np.float32]:
    try:
        return network.run(batch)
    except Exception as error:
        expected = f"expected a network that runs at {batch.shape[-1]} x {batch.shape[-1]}"
        raise RefusedError(f"{source}: {expected}, got: {one_line(error)[:300]}") from error
