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


def nobody(_: Scan) -> None:
    """Hears of it."""


class LaserDevice:
    """All of it is the thread's. moving: whether the robot's wheels turn: then no two scans are the same.

    hear: is told of every scan at once, in the thread; it must not wait for anything.
    """

    def __init__(
        self, driver: LaserDriver, moving: Callable[[], bool], hear: Callable[[Scan], object] = nobody
    ) -> None:
        self._driver, self._moving, self._hear = driver, moving, hear

    @property
    def health(self) -> Health:
        return self._driver.health

    def start(self) -> None:
        self._driver.start()

    def poll(self) -> Sequence[Scan]:
        scans = self._driver.read(self._moving())
        for scan in scans:
            self._hear(scan)
        return scans

    def close(self) -> None:
        self._driver.close()
