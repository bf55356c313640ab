# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Real-time scheduling for threads that drive, where the system lets them have it."""

from __future__ import annotations

import os

PRIORITY = 5
"""Above everything that is not in real time, below the kernel's own threads; the service's unit allows 10."""


def run_in_real_time(priority: int = PRIORITY) -> bool:
    """Asks for SCHED_FIFO for the calling thread, not for the threads and processes that it starts from now on.

    Whether it has it: without LimitRTPRIO in its unit, or privileges, a process may not.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except OSError:
        return False
    return True
