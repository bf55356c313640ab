# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Bags: recorded messages of topics, whatever the format of the file."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import AbstractSet, Iterator, NamedTuple, Optional, Protocol, Tuple

from edgefusion.errors import RefusedError


class BagTopic(NamedTuple):
    """name: as "/scan". type_name: as "sensor_msgs/msg/LaserScan". messages: how many there are."""

    name: str
    type_name: str
    messages: int


class BagMessage(NamedTuple):
    """log_ns: when it was recorded, since 1970. data: CDR with its header of four bytes."""

    topic: str
    type_name: str
    log_ns: int
    data: bytes


class Bag(Protocol):
    """What every bag can do. Its methods raise RefusedError for a file that is not as it should be."""

    @property
    def path(self) -> Path:
        """The file or folder."""
        ...

    @property
    def topics(self) -> Tuple[BagTopic, ...]:
        """All of them, by name."""
        ...

    def read(self, topics: Optional[AbstractSet[str]] = None) -> Iterator[BagMessage]:
        """The messages of some topics, or of all, in the order in which they were recorded."""
        ...


@contextmanager
def naming(bag: Bag, message: BagMessage) -> Iterator[None]:
    """Within this, what is refused is said of this message of the bag."""
    try:
        yield
    except RefusedError as error:
        raise RefusedError(f"{bag.path}: {message.topic} at {message.log_ns / 1e9:.3f} s: {error}") from error


def table(bag: Bag) -> str:
    """The topics, in one line, for people."""
    return ", ".join(f"{topic.name} ({topic.type_name}, {topic.messages})" for topic in bag.topics) or "no topics"
