# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A folder of images, one folder per class: what is in it, and what is refused."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.perception.model_folder import kind_of, read_file
from edgefusion.types import UNKNOWN

FEWEST = 5
"""Images a class: one of five is held out, and four folds of the others choose how strongly the head is held back."""


@dataclass(frozen=True)
class LabelledImages:
    """labels: of the classes, sorted. paths: of all images, class by class. classes: int[n], of each image."""

    labels: tuple[str, ...]
    paths: tuple[Path, ...]
    classes: npt.NDArray[np.intp]


def read_class_folders(root: Path) -> LabelledImages:
    """Lists the images of every class; what begins with a dot is left out. The images are not decoded yet.

    Raises RefusedError, one line, for fewer than two classes, a class with too few images or with a name that no
    label can have, the same image twice, and anything that is not in its place.
    """
    kind = kind_of(root)
    if kind != "a folder":
        raise RefusedError(f"{root}: expected a folder with a folder of images per class, got {kind}")
    folders = _visible(root)
    if len(folders) < 2:
        came = folders[0].name if folders else "none"
        raise RefusedError(f"{root}: expected two classes at least, a folder of images each, got {came}")
    images = [_images(folder) for folder in folders]
    paths = tuple(path for group in images for path in group)
    _expect_different(paths)
    classes = np.repeat(np.arange(len(folders)), [len(group) for group in images])
    return LabelledImages(tuple(folder.name for folder in folders), paths, classes)


def _visible(folder: Path) -> list[Path]:
    try:
        return sorted(path for path in folder.iterdir() if not path.name.startswith("."))
    except OSError as error:
        raise RefusedError(f"{folder}: expected a folder that can be read, got: {error.strerror}") from error


def _images(folder: Path) -> list[Path]:
    """The files of one class."""
    _expect_label(folder)
    if kind_of(folder) != "a folder":
        raise RefusedError(f"{folder}: expected a folder of images of one class, got a file beside the classes")
    paths = _visible(folder)
    for path in paths:
        if kind_of(path) != "a file":
            raise RefusedError(f"{path}: expected an image, got {kind_of(path)}")
    if len(paths) < FEWEST:
        raise RefusedError(f"{folder}: expected {FEWEST} images of a class at least, got {len(paths)}")
    return paths


def _expect_label(folder: Path) -> None:
    name = folder.name
    if name == UNKNOWN:
        came = "which is what an object without a name is called"
        raise RefusedError(f"{folder}: expected the name of a class, got {name}, {came}")
    if not name.isprintable() or name != name.strip():
        raise RefusedError(f"{folder}: expected a name of one printable line without spaces around it, got {name!r}")


def _expect_different(paths: tuple[Path, ...]) -> None:
    """A copy would be learnt and then asked for, or bear two names."""
    seen: dict[bytes, Path] = {}
    for path in paths:
        first = seen.setdefault(hashlib.sha256(read_file(path)).digest(), path)
        if first != path:
            raise RefusedError(f"{path}: expected every image once, got a copy of {first}")
