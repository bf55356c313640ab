# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A laptop's program that is started together with its robot."""

from __future__ import annotations

import time
from contextlib import suppress

from edgefusion import connect
from edgefusion.bus.client import Robot
from edgefusion.bus.session import UnreachableError


def joined(endpoint: str, within_s: float) -> Robot:
    """As soon as there is a router. Raises UnreachableError where there is none in time."""
    end_s = time.monotonic() + within_s
    while time.monotonic() < end_s:
        with suppress(UnreachableError):
            return connect(endpoint, timeout_s=0.5)
    raise UnreachableError(f"{endpoint}: expected a router within {within_s:g} s")
