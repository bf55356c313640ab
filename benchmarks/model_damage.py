# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A copy of a model folder, and what befalls its files: I1's bit flips, truncations, wrong files and wrong labels."""

from __future__ import annotations

import shutil
from contextlib import contextmanager
from pathlib import Path
from typing import Dict, Iterator

import numpy as np

import edgefusion
from edgefusion.perception.model_folder import GOLDEN, LABELS, MANIFEST, MODEL, checksum, sealed

LAB_MODEL = Path(edgefusion.__file__).parent / "data" / "lab-model"
FLIPS, CUTS = 300, 200


class ModelCopy:
    """path: a folder beside nothing else, whole again after each damage."""

    def __init__(self, original: Path, path: Path) -> None:
        self.path = Path(shutil.copytree(original, path))
        self._intact: Dict[str, bytes] = {file.name: file.read_bytes() for file in self.path.iterdir()}

    @contextmanager
    def with_file(self, name: str, content: bytes, forged: bool = False) -> Iterator[Path]:
        """Another content. forged: the manifest vouches for it, as of one who can write checksums."""
        (self.path / name).write_bytes(content)
        if forged:
            (self.path / MANIFEST).write_bytes(self._forged(name, content))
        try:
            yield self.path
        finally:
            for changed in (name, MANIFEST):
                (self.path / changed).write_bytes(self._intact[changed])

    def _forged(self, name: str, content: bytes) -> bytes:
        manifest = self._intact[MANIFEST]
        above = manifest[: manifest.rindex(b'"' + MANIFEST.encode())]
        return sealed(above.replace(checksum(self._intact[name]).encode(), checksum(content).encode()))

    def flips(self, seed: int, count: int = FLIPS) -> Iterator[bytes]:
        """The model, each time with another bit flipped."""
        intact, rng = self._intact[MODEL], np.random.default_rng(seed)
        return (_flipped(intact, int(bit)) for bit in rng.integers(0, 8 * len(intact), count))

    def cuts(self, count: int = CUTS) -> Iterator[bytes]:
        """The model's begin, of nothing at all to all but the last byte."""
        intact = self._intact[MODEL]
        return (intact[: int(length)] for length in np.linspace(0, len(intact) - 1, count))

    @property
    def wrong_models(self) -> Dict[str, bytes]:
        """What somebody may copy there instead of the model."""
        swapped = self._intact[GOLDEN]
        return {"nothing": b"", "a picture": swapped, "text": b"version https://git-lfs.github.com/spec/v1\n" * 3}

    @property
    def wrong_labels(self) -> Dict[str, bytes]:
        """Of another model."""
        lines = self._intact[LABELS].splitlines(keepends=True)
        return {"one more": b"".join([*lines, b"one more\n"]), "one less": b"".join(lines[:-1]), "none": b""}


def _flipped(intact: bytes, bit: int) -> bytes:
    content = bytearray(intact)
    content[bit // 8] ^= 1 << (bit % 8)
    return bytes(content)
