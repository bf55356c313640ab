# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A process beside the robot in a soak, that is told lines and says lines of JSON."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections import deque
from contextlib import suppress
from pathlib import Path
from typing import Deque, List

_ENDING_S = 20.0


class Player:
    """From its making until end(). words: what it says goes to a file. heard: what it said and nobody has taken yet."""

    def __init__(self, words: Path, *arguments: str) -> None:
        self._words = words.open("ab")
        self._process = subprocess.Popen(
            [sys.executable, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._words, text=True
        )
        self.heard: Deque[str] = deque()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def lives(self) -> bool:
        return self._process.poll() is None

    def tell(self, line: str) -> None:
        """One that is no more does not hear it."""
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.write(f"{line}\n")
            self._process.stdin.flush()

    def take(self) -> List[str]:
        """What it has said since the last time."""
        return [self.heard.popleft() for _ in range(len(self.heard))]

    def end(self, kill: bool = False) -> int:
        """Its exit code. kill: without asking."""
        self._process.kill() if kill else self._process.terminate()
        try:
            self._process.wait(_ENDING_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
        code = self._process.wait()
        self._thread.join(_ENDING_S)
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        self._words.close()
        return code

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with suppress(ValueError, KeyError, TypeError):
                self.heard.append(str(json.loads(line)["event"]))
