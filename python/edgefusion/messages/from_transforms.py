# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where frames are, as TFMessage."""

from __future__ import annotations

from typing import Sequence

from edgefusion.messages.geometry_msgs import Transform, TransformStamped, Vector3
from edgefusion.messages.rotations import quaternion_of
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.transform import FrameTransform


def from_transforms(stamp_ns: int, transforms: Sequence[FrameTransform], stamper: Stamper) -> TFMessage:
    """All as of then; for `tf` and, of what never moves, for `tf_static`."""
    return TFMessage([_stamped(stamp_ns, each, stamper) for each in transforms])


def _stamped(stamp_ns: int, transform: FrameTransform, stamper: Stamper) -> TransformStamped:
    T = transform.T_parent_child
    x, y, z = T[:3, 3].tolist()
    return TransformStamped(
        stamper.header(stamp_ns, transform.parent),
        transform.child,
        Transform(Vector3(x, y, z), quaternion_of(T[:3, :3])),
    )
