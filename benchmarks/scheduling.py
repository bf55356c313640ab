# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How processes of a benchmark are scheduled."""

from __future__ import annotations

import ctypes
import os

CORES = os.cpu_count() or 1

_PR_CAPBSET_DROP, _CAP_SYS_NICE = 24, 23


def unprivileged() -> None:
    """In a child, before it is another program: it gets no real time then, root's neither."""
    ctypes.CDLL(None).prctl(_PR_CAPBSET_DROP, _CAP_SYS_NICE, 0, 0, 0)
