# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Makes model folders, on a laptop; the robot only reads them (model_folder.py)."""

import dataclasses
import os
import shutil
import tempfile
from pathlib import Path
from typing import Callable, Dict, Optional, Sequence

import cv2
import msgspec
import numpy as np
import numpy.typing as npt
import tomli_w

from edgefusion.errors import RefusedError
from edgefusion.perception.golden import (
    SEEDS,
    TELLS_ENOUGH,
    TOLERANCES,
    GoldenAnswer,
    answer_of,
    golden_picture,
    lead_of,
    least_lead,
    telling,
)
from edgefusion.perception.model_folder import (
    GOLDEN,
    LABELS,
    MANIFEST,
    MODEL,
    VERSION,
    Boxes,
    Checksums,
    Input,
    Manifest,
    ModelFolder,
    Output,
    Training,
    checksum,
    kind_of,
    load_model_folder,
    read_file,
    read_picture,
    sealed,
)
from edgefusion.perception.network import (
    Network,
    RuntimeOptions,
    as_probabilities,
    expect_distributions,
    expect_finite,
    needs_softmax,
    one_line,
)
from edgefusion.perception.onnx_header import Precision
from edgefusion.perception.preprocessing import DEFAULT, Preprocessing, whole


def make_model_folder(
    onnx_file: Path,
    labels: Sequence[str],
    out_dir: Path,
    *,
    name: str,
    origin: str,
    licence: str,
    preprocessing: Preprocessing = DEFAULT,
    softmax: Optional[bool] = None,
    precision: Optional[Precision] = None,
    golden: Optional[Path] = None,
    boxes: Optional[Boxes] = None,
    training: Optional[Training] = None,
) -> ModelFolder:
    """Makes a model folder that appears whole or not at all, and is read back before it does.

    softmax, precision: found out where they are not given. golden: a picture; made up where none is given.
    Raises RefusedError, one line, for a model or a picture that will not do, and for a folder that exists.
    """
    if kind_of(out_dir) != "nothing":
        raise RefusedError(f"{out_dir}: expected a folder that is not there yet, got one that is")
    model = read_file(onnx_file)
    network = Network(model, str(onnx_file), RuntimeOptions(provider="cpu"))
    network.expect_size(preprocessing.size)

    def outputs(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        return _run(network, preprocessing.apply(picture, whole(picture)), str(onnx_file))

    first = read_picture(golden) if golden else golden_picture(SEEDS[0], preprocessing.size)
    network.expect_classes(len(labels), outputs(first))
    softmax = _softmax(softmax, outputs(first), str(onnx_file))

    def answer(picture: npt.NDArray[np.uint8]) -> GoldenAnswer:
        return answer_of(as_probabilities(outputs(picture), bool(softmax))[0])

    precision = precision or network.header.precision
    picture = first if golden else _telling(answer, preprocessing.size, precision)
    _expect_lead(golden or onnx_file, lead_of(answer(picture)), precision)

    files = {
        MODEL: model,
        LABELS: "".join(f"{label}\n" for label in labels).encode(),
        GOLDEN: _encode(picture),
    }
    manifest = Manifest(
        version=VERSION,
        name=name,
        origin=origin,
        licence=licence,
        precision=precision,
        input=Input(name=network.input_name, **msgspec.structs.asdict(preprocessing)),
        output=Output(name=network.output_name, softmax=softmax),
        golden=answer(picture),
        boxes=boxes,
        training=training,
        sha256=Checksums(model=checksum(files[MODEL]), labels=checksum(files[LABELS]), golden=checksum(files[GOLDEN])),
    )
    files[MANIFEST] = sealed(tomli_w.dumps(msgspec.to_builtins(manifest)).encode())
    return _write_whole(out_dir, files)


def fixed_size(onnx_file: Path) -> Optional[int]:
    """The size that a network file is fixed to, None where it takes any. Raises RefusedError."""
    return Network(read_file(onnx_file), str(onnx_file), RuntimeOptions(provider="cpu")).size


def _run(network: Network, batch: npt.NDArray[np.float32], source: str) -> npt.NDArray[np.float32]:
    """ONNX Runtime finds out only here that a network takes one size, though its input says any."""
    try:
        return network.run(batch)
    except Exception as error:
        size = batch.shape[-1]
        expected = f"expected a network that runs at {size} x {size}"
        raise RefusedError(f"{source}: {expected}, got: {one_line(error)}; --size may help") from error


def _softmax(wish: Optional[bool], outputs: npt.NDArray[np.float32], source: str) -> bool:
    """Whether one is needed; a wish that the outputs [1, classes] contradict is refused, as are outputs of NaN."""
    expect_finite(outputs, source)
    needed = needs_softmax(outputs)
    if wish and not needed:
        raise RefusedError(f"{source}: expected outputs that need a softmax, got probabilities: leave softmax off")
    if wish is False:
        expect_distributions(outputs, source)
    return needed if wish is None else wish


def _encode(picture: npt.NDArray[np.uint8]) -> bytes:
    return bytes(cv2.imencode(".png", picture)[1])


def _telling(
    answer: Callable[[npt.NDArray[np.uint8]], GoldenAnswer], size: int, precision: Precision
) -> npt.NDArray[np.uint8]:
    """The first made-up picture that tells enough, else the one that tells most."""
    best, most = golden_picture(SEEDS[0], size), -1.0
    for seed in SEEDS:
        picture = golden_picture(seed, size)
        tells = telling(answer(picture), TOLERANCES[precision])
        if tells > most:
            best, most = picture, tells
        if tells > TELLS_ENOUGH:
            break
    return best


def _expect_lead(source: Path, lead: float, precision: Precision) -> None:
    """NaN is refused, too."""
    least = least_lead(TOLERANCES[precision])
    if not lead > least:
        came = f"{lead:.2g}: give a golden picture that it knows"
        raise RefusedError(f"{source}: expected a best class with a lead above {least:g}, got {came}")


def _write_whole(out_dir: Path, files: Dict[str, bytes]) -> ModelFolder:
    """Written beside, read back, then renamed."""
    try:
        out_dir.parent.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(prefix=f".{out_dir.name}-", dir=out_dir.parent))
    except OSError as error:
        raise RefusedError(f"{out_dir}: expected a folder that can be made, got: {error.strerror}") from error
    try:
        for name, content in files.items():
            with (beside / name).open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        beside.chmod(0o755)
        folder = load_model_folder(beside)
        beside.rename(out_dir)
    except OSError as error:
        raise RefusedError(f"{out_dir}: expected a folder that can be made, got: {error.strerror}") from error
    finally:
        shutil.rmtree(beside, ignore_errors=True)
    return dataclasses.replace(folder, path=out_dir)
