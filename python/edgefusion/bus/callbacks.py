# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Zenoh prints what a callback raises and forgets it; here it is logged once, counted, and disturbs nobody.

Callbacks are called in the thread that reads from the network, and must be quick: threads that Zenoh would make for
them keep a program from ending, and queue whatever comes.
"""

from __future__ import annotations

import logging
from typing import Callable, Generic, TypeVar

from zenoh.handlers import Callback

log = logging.getLogger(__name__)

T = TypeVar("T")


class Guarded(Generic[T]):
    """A callback that never raises. failures: how often what it calls has."""

    def __init__(self, name: str, call: Callable[[T], None]) -> None:
        self._name, self._call = name, call
        self.failures = 0

    @property
    def handler(self) -> Callback[T]:
        """What Zenoh is given."""
        return Callback(self, indirect=False)

    def __call__(self, item: T) -> None:
        try:
            self._call(item)
        except Exception:
            self.failures += 1
            if self.failures == 1:
                log.exception("%s: a callback failed; further failures are only counted", self._name)
