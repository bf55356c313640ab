# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a thread that is reading from a device is asked to end: its next read does not wait for the device."""

from __future__ import annotations

from typing import Any

from edgefusion.drivers.link import Link


class EndedError(Exception):
    """The reading was ended by whoever asked for it. No LinkError: nothing is wrong with the line."""


class Ending:
    """Asked for by any thread, once; the thread that ends then begins to close, and may read again for that."""

    def __init__(self) -> None:
        self.asked = False
        self._closing = False

    def ask(self) -> None:
        self.asked = True

    def close(self) -> None:
        """From here on the thread itself decides what it still reads."""
        self._closing = True

    def check(self) -> None:
        """Raises EndedError between the two."""
        if self.asked and not self._closing:
            raise EndedError("asked to end")


class EndableLink(Link):
    """A link whose user may be in the middle of a search of seconds, and still ends within a read's 20 ms."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.ending = Ending()

    def read(self, n: int) -> bytes:
        """As Link.read. Raises EndedError, too."""
        self.ending.check()
        return super().read(n)
