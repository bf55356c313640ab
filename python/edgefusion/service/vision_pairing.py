# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The newest scan and frame that were captured together: who is slow gets those, not the ones that he has missed."""

from __future__ import annotations

from typing import Sequence

from edgefusion.config import SyncConfig
from edgefusion.perception.sync import Pair, Synchronizer
from edgefusion.types import Frame, Scan


class NewestPair:
    """overtaken: how many pairs nobody got, as newer ones were there."""

    def __init__(self, config: SyncConfig) -> None:
        self._config = config
        self.overtaken = 0
        self.forget()

    def forget(self) -> None:
        """Nothing that came before is paired any more."""
        self._sync = Synchronizer(round(self._config.tolerance_s * 1e9), round(self._config.horizon_s * 1e9))

    def add(self, scans: Sequence[Scan], frames: Sequence[Frame]) -> Pair | None:
        """The newest pair that is complete with these, if any is. Frames first: they are there before their scans."""
        pairs = [pair for frame in frames for pair in self._sync.add_frame(frame)]
        pairs += [pair for scan in scans for pair in self._sync.add_scan(scan)]
        self.overtaken += max(len(pairs) - 1, 0)
        return pairs[-1] if pairs else None
