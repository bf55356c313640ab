# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The laser as its thread owns it."""

from __future__ import annotations

from typing import Protocol, Sequence

from edgefusion.types import Health, Scan


class LaserDriver(Protocol):
    """As drivers.lms2xx.Lms2xx is."""

    @property
    def health(self) -> Health: ...

    def start(self) -> None: ...

    def read(self) -> list[Scan]: ...

    def close(self) -> None: ...


class LaserDevice:
    """All of it is the thread's."""

    def __init__(self, driver: LaserDriver) -> None:
        self._driver = driver

    @property
    def health(self) -> Health:
        return self._driver.health

    def start(self) -> None:
        self._driver.start()

    def poll(self) -> Sequence[Scan]:
        return self._driver.read()

    def close(self) -> None:
        self._driver.close()
