# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where frames are, from TFMessage."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from edgefusion.messages.cdr import WireError
from edgefusion.messages.geometry_msgs import TransformStamped
from edgefusion.messages.rotations import rotation_of
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.transform import FrameTransform


class StampedTransform(NamedTuple):
    """Where a frame was."""

    stamp_ns: int
    transform: FrameTransform


def to_transforms(message: TFMessage, stamper: Stamper) -> list[StampedTransform]:
    """Raises WireError for a transform that is none."""
    return [StampedTransform(stamper.to_ns(each.header.stamp), _transform(each)) for each in message.transforms]


def _transform(message: TransformStamped) -> FrameTransform:
    parent, child = message.header.frame_id, message.child_frame_id
    if not parent or not child:
        raise WireError(f"tf: expected the names of two frames, got {parent!r} and {child!r}")
    at = message.transform.translation
    T = np.eye(4)
    T[:3, 3] = at.x, at.y, at.z
    if not np.isfinite(T).all():
        raise WireError(f"tf: {child}: expected a place in finite metres, got {(at.x, at.y, at.z)}")
    T[:3, :3] = rotation_of(message.transform.rotation, f"tf: {child}")
    return FrameTransform(parent, child, T)
