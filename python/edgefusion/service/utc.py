# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The offset of the robot's clock to UTC: taken once, so that a wall clock that steps later changes nothing."""

from __future__ import annotations

import os
import time
from typing import Mapping

from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError

ENVIRONMENT = "EDGEFUSION_UTC_OFFSET_NS"
"""In which the supervisor hands it to its children."""


def taken_offset_ns(clock: Clock = system_clock, utc: Clock = time.time_ns) -> int:
    """What is to be added to the clock's nanoseconds for nanoseconds since 1970 in UTC, as it is now."""
    before_ns = clock()
    utc_ns = utc()
    return utc_ns - (before_ns + clock()) // 2


def utc_offset_ns(
    environment: Mapping[str, str] | None = None, clock: Clock = system_clock, utc: Clock = time.time_ns
) -> int:
    """The supervisor's, or one taken now by a process that runs alone. Raises RefusedError for what is no number."""
    text = (os.environ if environment is None else environment).get(ENVIRONMENT)
    if text is None:
        return taken_offset_ns(clock, utc)
    try:
        return int(text)
    except ValueError:
        raise RefusedError(f"{ENVIRONMENT}: expected whole nanoseconds, got {text!r}") from None
