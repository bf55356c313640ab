# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The model folder: a network, all that is needed to use it, and the proof that it is the same one.

    model.onnx     labels.txt (one a line, in the order of the outputs)     golden.png     manifest.toml

The manifest holds the checksums of the other three, the preprocessing, and the golden answer. Its last line is its
own seal: the checksum of all that is above. Made by make_model.py; what is here is all that a robot needs.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Optional, Tuple

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.config import HeightRule, Heights
from edgefusion.errors import RefusedError
from edgefusion.perception.golden import TOLERANCES, Golden, GoldenAnswer
from edgefusion.perception.network import one_line
from edgefusion.perception.onnx_header import Precision
from edgefusion.perception.preprocessing import Preprocessing
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


class Boxes(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Which candidate boxes the network was trained to tell apart; as in PerceptionConfig, where it says nothing."""

    heights: Heights
    heights_in: Literal["widths", "metres"]
    height_rule: HeightRule


class Training(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the network came about: the command that repeats it, and the share of crops that it named on worlds or
    pictures that it was not trained on."""

    command: str
    seed: int
    accuracy: float
    held_out: str


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


class Manifest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, omit_defaults=True):
    """manifest.toml. What a network needs has no default: what is not said is not known. boxes and training are there
    for those that were trained by us."""

    version: Literal[1]
    name: str
    origin: str
    licence: str
    precision: Precision
    input: Input
    output: Output
    golden: GoldenAnswer
    boxes: Optional[Boxes] = None
    training: Optional[Training] = None
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
    return f'"{MANIFEST}" = "{checksum(manifest)}"\n'.encode()


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
    came = checksum(content)
    if came != expected:
        raise RefusedError(f"{path}: expected SHA-256 {expected}, got {came}: the file was changed")
    return content


def checksum(content: bytes) -> str:
    """SHA-256, hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def read_picture(path: Path) -> npt.NDArray[np.uint8]:
    """BGR uint8 [height, width, 3]. Raises RefusedError."""
    return _decode(path, read_file(path))


def _decode(path: Path, content: bytes) -> npt.NDArray[np.uint8]:
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR) if content else None
    except cv2.error as error:
        raise RefusedError(f"{path}: expected a picture, got one that OpenCV refuses: {one_line(error)}") from error
    if picture is None:
        raise RefusedError(f"{path}: expected a picture, got {len(content)} bytes that are none")
    return np.asarray(picture, np.uint8)
