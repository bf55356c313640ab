# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Clocks, passed in wherever time is needed: nanoseconds that never step back."""

from __future__ import annotations

import time
from typing import Callable

Clock = Callable[[], int]
"""Returns nanoseconds of a monotonic clock."""

system_clock: Clock = time.monotonic_ns
