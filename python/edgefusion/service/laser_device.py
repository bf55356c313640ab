# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The laser as its thread owns it."""

from __future__ import annotations

from typing import Callable, Protocol, Sequence

from edgefusion.types import Health, Scan


class LaserDriver(Protocol):
    """As drivers.lms2xx.Lms2xx is."""

    @property
    def health(self) -> Health: ...

    def start(self) -> None: ...

    def read(self, moving: bool = False) -> list[Scan]: ...

    def close(self) -> None: ...


class LaserDevice:
    """All of it is the thread's. moving: whether the robot's wheels turn: then no two scans are the same."""

    def __init__(self, driver: LaserDriver, moving: Callable[[], bool]) -> None:
        self._driver, self._moving = driver, moving

    @property
    def health(self) -> Health:
        return self._driver.health

    def start(self) -> None:
        self._driver.start()

    def poll(self) -> Sequence[Scan]:
        return self._driver.read(self._moving())

    def close(self) -> None:
        self._driver.close()
