# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which processes ended in a soak though nobody had meant them to."""

from __future__ import annotations

from typing import Dict, List, Mapping, Set


class Lives:
    """Looks again and again at who lives, by name. spared: names of those that end as they like."""

    def __init__(self, *spared: str) -> None:
        self._spared = spared
        self._pids: Dict[str, int] = {}
        self._doomed: Set[str] = set()

    def doom(self, name: str) -> None:
        """It is to end now, or soon, once."""
        self._doomed.add(name)

    def look(self, pids: Mapping[str, int]) -> List[str]:
        """Those that are no more, or are others, since the last look."""
        gone = [name for name, pid in self._pids.items() if pids.get(name) != pid and name not in self._spared]
        ended = [name for name in gone if name not in self._doomed]
        self._doomed.difference_update(gone)
        self._pids = dict(pids)
        return ended
