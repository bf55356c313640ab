# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which clock a stamp is of: CLOCK_MONOTONIC counts from the boot, so the boot's id names it."""

from __future__ import annotations

from pathlib import Path

BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


def clock_id(path: Path = BOOT_ID) -> str:
    """The id of this computer's monotonic clock. Raises OSError where the kernel does not tell it."""
    return path.read_text(encoding="ascii").strip()
