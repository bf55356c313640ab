# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What goes along with a sample, in its attachment, as JSON: who has sent it, the how many-th it is, and when it is of.

A command carries no stamp: its sender's clock is not the robot's.
"""

from __future__ import annotations

import itertools
import sys
import uuid
from typing import Optional, Type, TypeVar

import msgspec

from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

MOST_BYTES = 512

Id = Annotated[str, msgspec.Meta(min_length=1, max_length=64, pattern=r"^[ -~]*\Z")]  # it goes into logs
Count = Annotated[int, msgspec.Meta(ge=0, le=2**53)]


class SampleTag(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Of what the robot publishes. clock: whose stamp_ns it is."""

    clock: Id
    stamp_ns: Annotated[int, msgspec.Meta(ge=0, le=2**63 - 1)]
    session: Id
    seq: Count


class CommandTag(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Of what the robot is told. seq rises within a session. ttl_ms: the command is worth nothing when it is older."""

    session: Id
    seq: Count
    ttl_ms: Annotated[int, msgspec.Meta(ge=1, le=60_000)]


T = TypeVar("T", SampleTag, CommandTag)


class Tagger:
    """Numbers what one process sends."""

    def __init__(self, session: str = "") -> None:
        self._session = session or uuid.uuid4().hex
        self._count = itertools.count()  # its next() is one step also between threads

    def sample(self, clock: str, stamp_ns: int) -> bytes:
        """The attachment of the next sample."""
        return msgspec.json.encode(SampleTag(clock, stamp_ns, self._session, next(self._count)))

    def command(self, ttl_ms: int) -> bytes:
        """The attachment of the next command."""
        return msgspec.json.encode(CommandTag(self._session, next(self._count), ttl_ms))


def read_tag(kind: Type[T], attachment: bytes) -> T:
    """Raises RefusedError for what is none."""
    if len(attachment) > MOST_BYTES:
        raise RefusedError(f"tag: expected at most {MOST_BYTES} bytes, got {len(attachment)}")
    try:
        return msgspec.json.decode(attachment, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:  # a ValidationError is a DecodeError
        raise RefusedError(f"tag: {error}") from error


def session_of(attachment: Optional[bytes]) -> str:
    """Of a command's sender; empty where there is none that could be read."""
    try:
        return "" if attachment is None else read_tag(CommandTag, attachment).session
    except RefusedError:
        return ""
