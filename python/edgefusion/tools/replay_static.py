# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What never moves, told again for who comes late."""

from __future__ import annotations

from typing import Dict, NamedTuple, Optional

from edgefusion.messages.cdr import decode
from edgefusion.messages.geometry_msgs import TransformStamped
from edgefusion.messages.tf2_msgs import TFMessage

STATIC_NS = 1_000_000_000
"""So often it is told again."""


class _Told(NamedTuple):
    transform: TransformStamped
    at_ns: int


class Standing:
    """Where every frame is, as it was told last: ROS tells it once, each of many publishers its own.

    newest_ns: the newest stamp among them.
    """

    def __init__(self) -> None:
        self._told: Dict[str, _Told] = {}
        self.newest_ns = 0

    def heard(self, payload: bytes, stamp_ns: int, now_ns: int) -> None:
        """It was told at now_ns. payload: a TFMessage. Raises WireError for one that is none."""
        for transform in decode(TFMessage, payload).transforms:
            self._told[transform.child_frame_id] = _Told(transform, now_ns)
        self.newest_ns = max(self.newest_ns, stamp_ns)

    def due(self, now_ns: int) -> Optional[TFMessage]:
        """What was told too long ago, to be told again now; None where nothing was."""
        late = {child: told.transform for child, told in self._told.items() if now_ns - told.at_ns >= STATIC_NS}
        self._told.update({child: _Told(transform, now_ns) for child, transform in late.items()})
        return TFMessage(list(late.values())) if late else None
