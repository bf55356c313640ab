# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where frames are that never move against each other, as a bag's transforms tell it."""

from __future__ import annotations

from itertools import islice
from typing import Dict, Iterator, Optional, Set, Tuple

import numpy as np
import numpy.typing as npt

from edgefusion.messages import ros_name
from edgefusion.messages.cdr import decode
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.to_transforms import to_transforms
from edgefusion.messages.transform import FrameTransform
from edgefusion.recording.bag import Bag, naming

Matrix = npt.NDArray[np.float64]

MOST_MESSAGES = 1000
"""Of `tf`, which tells what stands still again and again."""

TYPES = (ros_name(TFMessage), "tf/msg/tfMessage")


class FrameTree:
    """Frames and where they are in their parents; of one that moves, nothing is known."""

    def __init__(self) -> None:
        self._parents: Dict[str, FrameTransform] = {}
        self._moving: Set[str] = set()

    @property
    def frames(self) -> list[str]:
        """All that have a place, and their parents."""
        return sorted({name for one in self._parents.values() for name in (one.parent, one.child)})

    def add(self, transform: FrameTransform) -> None:
        """Where a frame is, again or for the first time."""
        child = plain(transform.child)
        known = self._parents.get(child)
        if child in self._moving:
            return
        if known and (
            known.parent != plain(transform.parent)
            or not np.allclose(known.T_parent_child, transform.T_parent_child, atol=1e-6)
        ):
            del self._parents[child]
            self._moving.add(child)
        else:
            self._parents[child] = FrameTransform(plain(transform.parent), child, transform.T_parent_child)

    def transform(self, into: str, of: str) -> Optional[Matrix]:
        """T_into_of [4, 4], which maps coordinates of one frame into another; None where it is not known."""
        (root_into, T_root_into), (root_of, T_root_of) = self._from_root(plain(into)), self._from_root(plain(of))
        if root_into != root_of:
            return None
        return np.asarray(np.linalg.inv(T_root_into) @ T_root_of, float)

    def _from_root(self, frame: str) -> Tuple[str, Matrix]:
        T: Matrix = np.eye(4)
        seen = set()
        while frame in self._parents and frame not in seen:  # a bag may say that frames go round in a circle
            seen.add(frame)
            T = self._parents[frame].T_parent_child @ T
            frame = self._parents[frame].parent
        return frame, T


def read_tree(bag: Bag) -> FrameTree:
    """From tf_static, and from the beginning of tf, where ROS 1 has what does not move. Raises RefusedError."""
    tree = FrameTree()
    for name, most in (("tf_static", None), ("tf", MOST_MESSAGES)):
        for transform in _transforms(bag, name, most):
            tree.add(transform)
    return tree


def plain(frame: str) -> str:
    """A frame's name without the slash that ROS 1 may put before it."""
    return frame.lstrip("/")


def _transforms(bag: Bag, name: str, most: Optional[int]) -> Iterator[FrameTransform]:
    topics = {t.name for t in bag.topics if t.type_name in TYPES and t.name.strip("/").split("/")[-1] == name}
    if not topics:
        return
    for message in islice(bag.read(topics), most):
        with naming(bag, message):
            transforms = to_transforms(decode(TFMessage, message.data), Stamper())
        yield from (each.transform for each in transforms)
