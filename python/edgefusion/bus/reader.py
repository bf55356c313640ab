# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a laptop makes of messages: who talks nonsense on a topic takes nobody's program down."""

from __future__ import annotations

import logging
from typing import Any, Callable, Generic, Optional, TypeVar

from edgefusion.bus.topics import Topic
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import decode

log = logging.getLogger(__name__)

T = TypeVar("T")


class Reader(Generic[T]):
    """convert: makes of a message what is wanted of it, or raises RefusedError. refused: how many were none."""

    def __init__(self, topic: Topic, convert: Callable[[Any], T]) -> None:
        self._topic, self._convert = topic, convert
        self.refused = 0

    def read(self, payload: bytes) -> Optional[T]:
        """None for what is no such message: the first is said in the log, the others are only counted."""
        try:
            return self._convert(decode(self._topic.message, payload))
        except RefusedError as error:
            self.refused += 1
            if self.refused == 1:
                log.warning("%s: left out, and from now on only counted: %s", self._topic.name, error)
            return None
