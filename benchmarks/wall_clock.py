# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The wall clock of processes, moved while they run: theirs alone, by a small library that they load first."""

from __future__ import annotations

import shutil
import struct
import subprocess
from pathlib import Path
from typing import Dict

_SOURCE = Path(__file__).with_name("wall_clock.c")


class WallClock:
    """environment: of the processes whose clock it is. Raises RuntimeError where no C compiler is, or it fails."""

    def __init__(self, folder: Path) -> None:
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            raise RuntimeError("no C compiler")
        library = folder / "wall_clock.so"
        command = [compiler, "-O2", "-shared", "-fPIC", "-o", str(library), str(_SOURCE), "-ldl", "-lpthread"]
        made = subprocess.run(command, capture_output=True, text=True, check=False)
        if made.returncode:
            raise RuntimeError(f"wall_clock.c: {made.stderr.strip().splitlines()[-1]}")
        self._file = folder / "wall_clock"
        self._file.write_bytes(bytes(8))
        self.environment: Dict[str, str] = {"LD_PRELOAD": str(library), "WALL_CLOCK_FILE": str(self._file)}

    def set(self, ahead_s: float) -> None:
        """From now on it is ahead of the true one by so much, or behind."""
        with self._file.open("r+b") as file:
            file.write(struct.pack("<q", round(ahead_s * 1e9)))
