# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The model folder: a network, all that is needed to use it, and the proof that it is the same one.

    model.onnx     labels.txt (one a line, in the order of the outputs)     golden.png     manifest.toml

The manifest holds the checksums of the other three, the preprocessing, and the golden answer. Its last line is its
own seal: the checksum of all that is above.
"""

import dataclasses
import hashlib
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Literal, Optional, Sequence, Tuple

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
    Golden,
    GoldenAnswer,
    answer_of,
    golden_picture,
    lead_of,
    least_lead,
    telling,
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
from edgefusion.types import UNKNOWN

VERSION: Literal[1] = 1
MODEL, LABELS, GOLDEN, MANIFEST = "model.onnx", "labels.txt", "golden.png", "manifest.toml"


class Input(Preprocessing, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The network's input: its name, and the preprocessing that it was trained with."""

    name: str


class Output(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The network's output; softmax: whether it needs one to become probabilities."""

    name: str
    softmax: bool


class Checksums(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    kw_only=True,
    rename={"model": MODEL, "labels": LABELS, "golden": GOLDEN},
):
    """SHA-256 of the files beside the manifest, hexadecimal."""

    model: str
    labels: str
    golden: str


class Manifest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """manifest.toml. Nothing in it has a default: what is not said is not known."""

    version: Literal[1]
    name: str
    origin: str
    licence: str
    precision: Precision
    input: Input
    output: Output
    golden: GoldenAnswer
    sha256: Checksums


@dataclass(frozen=True)
class ModelFolder:
    """A model folder whose files are those that its manifest vouches for. model: the ONNX file's bytes."""

    path: Path
    manifest: Manifest
    labels: Tuple[str, ...]
    model: bytes
    golden: Golden


def load_model_folder(path: Path) -> ModelFolder:
    """Reads and checks every file of the folder; what the network answers is the classifier's to check.

    Raises RefusedError, one line, for a missing, changed or malformed file and for a newer version.
    """
    kind = kind_of(path)
    if kind != "a folder":
        raise RefusedError(f"{path}: expected a model folder, got {kind}")
    manifest = _read_manifest(path / MANIFEST)
    model = _read_checked(path / MODEL, manifest.sha256.model)
    labels = _split(path / LABELS, _read_checked(path / LABELS, manifest.sha256.labels))
    picture = _decode(path / GOLDEN, _read_checked(path / GOLDEN, manifest.sha256.golden))
    highest = max(manifest.golden.classes)
    if min(manifest.golden.classes) < 0 or highest >= len(labels):
        raise RefusedError(f"{path / MANIFEST}: expected golden.classes of 0..{len(labels) - 1}, got {highest}")
    golden = Golden(picture, manifest.golden, TOLERANCES[manifest.precision])
    return ModelFolder(path, manifest, labels, model, golden)


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

    first = _read_picture(golden) if golden else golden_picture(SEEDS[0], preprocessing.size)
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
        sha256=Checksums(model=_sha256(files[MODEL]), labels=_sha256(files[LABELS]), golden=_sha256(files[GOLDEN])),
    )
    files[MANIFEST] = sealed(tomli_w.dumps(msgspec.to_builtins(manifest)).encode())
    return _write_whole(out_dir, files)


def fixed_size(onnx_file: Path) -> Optional[int]:
    """The size that a network file is fixed to, None where it takes any. Raises RefusedError."""
    return Network(read_file(onnx_file), str(onnx_file), RuntimeOptions(provider="cpu")).size


def read_labels(path: Path) -> Tuple[str, ...]:
    """One label a line. Two classes may share a label, as two of ImageNet's do. Raises RefusedError."""
    return _split(path, read_file(path))


def _split(path: Path, content: bytes) -> Tuple[str, ...]:
    try:
        lines = content.decode("utf-8-sig").rstrip().splitlines()
    except UnicodeDecodeError as error:
        raise RefusedError(f"{path}: expected UTF-8 text, got {one_line(error)}") from error
    labels = tuple(line.strip() for line in lines)
    if not labels or "" in labels:
        came = f"nothing on line {labels.index('') + 1}" if labels else "an empty file"
        raise RefusedError(f"{path}: expected a label on every line, got {came}")
    if UNKNOWN in labels:
        line = labels.index(UNKNOWN) + 1
        expected = f"labels other than {UNKNOWN}, which is what an object without a name is called"
        raise RefusedError(f"{path}: expected {expected}, got it on line {line}")
    return labels


def sealed(manifest: bytes) -> bytes:
    """A manifest, which ends in the table [sha256], with the seal below it."""
    return manifest + _seal(manifest)


def _seal(manifest: bytes) -> bytes:
    return f'"{MANIFEST}" = "{_sha256(manifest)}"\n'.encode()


def _unsealed(path: Path, content: bytes) -> bytes:
    """What is above the seal. Raises RefusedError where that is not what was sealed."""
    manifest = content[: -len(_seal(b""))]
    if content != sealed(manifest):
        raise RefusedError(f"{path}: expected its own SHA-256 on the last line, got another: the file was changed")
    return manifest


def _read_manifest(path: Path) -> Manifest:
    """The version first: a newer one may be sealed in another way."""
    content = read_file(path)
    try:
        version = msgspec.toml.decode(content).get("version")
        if version != VERSION:
            raise RefusedError(f"{path}: expected version = {VERSION}, got {_version(version)}")
        return msgspec.toml.decode(_unsealed(path, content), type=Manifest)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise RefusedError(f"{path}: expected the manifest of a model, got: {one_line(error)}") from error


def _version(version: object) -> str:
    if isinstance(version, int) and version > VERSION:
        return f"{version}: made by a newer edgefusion than this one"
    return "none" if version is None else repr(version)


def kind_of(path: Path) -> Literal["a folder", "a file", "nothing"]:
    """What is there. Raises RefusedError where not even that can be found out."""
    try:
        return "a folder" if path.is_dir() else "a file" if path.exists() else "nothing"
    except OSError as error:
        raise RefusedError(f"{path}: expected a path that can be looked up, got: {error.strerror}") from error


def read_file(path: Path) -> bytes:
    """All of a file. Raises RefusedError."""
    try:
        return path.read_bytes()
    except FileNotFoundError as error:
        raise RefusedError(f"{path}: expected a file, got nothing") from error
    except OSError as error:
        raise RefusedError(f"{path}: expected a file that can be read, got: {error.strerror}") from error


def _read_checked(path: Path, expected: str) -> bytes:
    content = read_file(path)
    came = _sha256(content)
    if came != expected:
        raise RefusedError(f"{path}: expected SHA-256 {expected}, got {came}: the file was changed")
    return content


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _read_picture(path: Path) -> npt.NDArray[np.uint8]:
    return _decode(path, read_file(path))


def _decode(path: Path, content: bytes) -> npt.NDArray[np.uint8]:
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR) if content else None
    except cv2.error as error:
        raise RefusedError(f"{path}: expected a picture, got one that OpenCV refuses: {one_line(error)}") from error
    if picture is None:
        raise RefusedError(f"{path}: expected a picture, got {len(content)} bytes that are none")
    return np.asarray(picture, np.uint8)


def _encode(picture: npt.NDArray[np.uint8]) -> bytes:
    return bytes(cv2.imencode(".png", picture)[1])


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
