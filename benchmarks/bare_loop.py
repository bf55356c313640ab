# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a machine lets a loop of 20 Hz be that is nothing else: it works for 8 ms of each cycle, as a base does, for as
many cycles as its argument says, and prints by how much 99 of 100 of them were late [ms]."""

from __future__ import annotations

import sys
import time

from edgefusion.service.cadence import Cadence

PERIOD_NS, WORK_S = 50_000_000, 0.008


def main() -> None:
    cadence = Cadence(PERIOD_NS, time.monotonic_ns, time.sleep)
    for _ in range(int(sys.argv[1])):
        cadence.next()
        end_s = time.thread_time() + WORK_S
        while time.thread_time() < end_s:
            pass
    print(cadence.lateness.p99_ms)


if __name__ == "__main__":
    main()
