# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a device's thread has to tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from edgefusion.types import Health

T = TypeVar("T")


@dataclass(frozen=True)
class DeviceNews(Generic[T]):
    """newest: of what came since the device was started; None before the first, and while the device is lost.

    received_ns: when that came. failures: how often the device has become FAILED so far; failure: why, the last time.
    Who finds another number than before has missed nothing, though the device may be well again.
    """

    health: Health
    newest: T | None = None
    received_ns: int | None = None
    failures: int = 0
    failure: str = ""
