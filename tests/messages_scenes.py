# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the tests of messages share."""

from __future__ import annotations

import math
from typing import TypeVar

from hypothesis import strategies as st

from edgefusion.messages import Message
from edgefusion.messages.cdr import decode, encode
from edgefusion.messages.stamps import Stamper
from edgefusion.types import Pose2D

M = TypeVar("M", bound=Message)

STAMPER = Stamper(offset_ns=1_700_000_000_000_000_007)
STAMP_NS = 123_456_789_012

stamps_ns = st.integers(0, 10**17)
metres = st.floats(-500, 500)
poses = st.builds(Pose2D, metres, metres, st.floats(-10, 10))


def sent(message: M) -> M:
    """The message after its way over the wire."""
    return decode(type(message), encode(message))


def is_same_pose(found: Pose2D, expected: Pose2D) -> bool:
    """Whichever way the angle is counted."""
    turned = math.remainder(found.theta - expected.theta, 2 * math.pi)
    return (found.x_m, found.y_m) == (expected.x_m, expected.y_m) and abs(turned) < 1e-9
