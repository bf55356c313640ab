# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Real-time scheduling for threads that drive, where the system lets them have it."""

from __future__ import annotations

import logging
import os
from typing import List

PRIORITY = 5
"""Above everything that is not in real time, below the kernel's own threads; the service's unit allows 10."""

log = logging.getLogger(__name__)


def run_in_real_time(priority: int = PRIORITY) -> bool:
    """Asks for SCHED_FIFO for the calling thread, not for the threads and processes that it starts from now on.

    Whether it has it: without LimitRTPRIO in its unit, or privileges, a process may not.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except OSError:
        return False
    return True


def scheduling() -> str:
    """How the calling thread is scheduled, in words: `real time, priority 5`, or `shared, nice 10`."""
    if os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK in (os.SCHED_FIFO, os.SCHED_RR):
        return f"real time, priority {os.sched_getparam(0).sched_priority}"
    return f"shared, nice {os.getpriority(os.PRIO_PROCESS, 0)}"


class RealTime:
    """To be called first of all by every thread that drives: asks for it, and keeps what became of that. The first
    answer is logged."""

    def __init__(self, priority: int = PRIORITY) -> None:
        self._priority = priority
        self._had: List[bool] = []

    def __call__(self) -> None:
        had = run_in_real_time(self._priority)
        self._had.append(had)
        if len(self._had) > 1:
            return
        if had:
            log.info("drives in real time (SCHED_FIFO, priority %d)", self._priority)
        else:
            log.warning("real time: not allowed (LimitRTPRIO in its unit): a busy computer makes commands late")

    def __str__(self) -> str:
        """Of how many threads how many have it."""
        return f"{sum(self._had)} of {len(self._had)} threads"
