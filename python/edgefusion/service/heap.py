# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A process that runs for months must not grow with what it has once held."""

from __future__ import annotations

import ctypes

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_ARENA_MAX = -1, -3, -8
"""Of glibc's malloc.h."""

ARENAS = 2
LARGE_BYTES = 256 * 1024


def give_back_early() -> bool:
    """To be called before there are threads: what is large goes back to the system as soon as it is freed.

    Pictures and tensors are allocated and freed by turns in a dozen threads. By itself glibc gives each thread an arena
    of its own, and keeps ever larger pieces in it once it has seen one freed: each arena fills up and none is given
    back. Whether it took: only glibc has these settings.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):
        return False
    settings = ((M_ARENA_MAX, ARENAS), (M_MMAP_THRESHOLD, LARGE_BYTES), (M_TRIM_THRESHOLD, LARGE_BYTES))
    taken = [mallopt(name, value) == 1 for name, value in settings]
    return all(taken)
