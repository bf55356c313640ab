# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Messages as bytes and back: plain CDR with its header of four bytes, as ROS 2 has it on the wire and in files."""

from __future__ import annotations

import struct
from typing import Any, TypeVar, cast

from pycdr2._support import Buffer, Endianness

from edgefusion.errors import RefusedError
from edgefusion.messages import registry  # noqa: F401  # makes the types ready
from edgefusion.messages.idl import Message, ros_name

M = TypeVar("M", bound=Message)

MOST_BYTES = 1 << 26
"""Of one message: nothing that a robot says is longer."""

MOST_CHARACTERS = 400
"""Of what an error says."""

_HEADER_BYTES = 4
_BIG, _LITTLE = b"\x00\x00", b"\x00\x01"
_WORD_BYTES = 4
"""To a multiple of so many some writers pad what they have written."""


class WireError(RefusedError):
    """Bytes that are not the message that they should be, or a message that bytes cannot hold.

    Its line quotes what somebody else has sent: it stays one, printable and short.
    """

    def __init__(self, line: str) -> None:
        super().__init__("".join(map(_printable, line[:MOST_CHARACTERS])))


def encode(message: Message) -> bytes:
    """The message in little-endian CDR.

    Raises WireError for a value that its field cannot hold.
    """
    try:
        # Not the type's own buffer, which all threads would share.
        return message.serialize(buffer=Buffer(), endianness=Endianness.Little)
    except Exception as error:  # pycdr2 raises no other
        raise WireError(f"{ros_name(type(message))}: {_what_does_not_fit(error)}") from error


def decode(cls: type[M], data: bytes) -> M:
    """The message of a type from its CDR, of either byte order; nothing but zeros up to a whole word may follow it.

    Raises WireError, and nothing else, whatever the bytes are; it allocates no more than in proportion to them.
    """
    try:
        reader = _Reader(data)
        message = cls.__idl__.deserialize(reader, has_header=False)
        reader.check_end()
    except (WireError, UnicodeDecodeError) as error:
        raise WireError(f"{ros_name(cls)}: {error}") from None
    return cast(M, message)


class _Reader(Buffer):
    """pycdr2's buffer, which believes every length that it reads; this one looks first.

    It is read from behind the header, from which alignment counts.
    """

    def __init__(self, data: bytes) -> None:
        if not _HEADER_BYTES <= len(data) <= MOST_BYTES:
            raise WireError(f"expected {_HEADER_BYTES} to {MOST_BYTES} bytes, got {len(data)}")
        kind = bytes(data[:2])
        if kind not in (_BIG, _LITTLE):
            raise WireError(f"expected plain CDR, 0000 or 0001, got {kind.hex()}")
        super().__init__(data, align_offset=_HEADER_BYTES)
        self.set_endianness(Endianness.Little if kind == _LITTLE else Endianness.Big)
        self.seek(_HEADER_BYTES)

    def read(self, pack: str, size: int) -> Any:
        """A number; also the end of a text, which pycdr2 reads as an int8, of which no message has a field."""
        self._check(size)
        (value,) = struct.unpack_from(self._endian + pack, self._bytes, self._pos)
        if pack == "b" and value != 0:
            raise WireError(f"expected a text to end with 0 at {self._pos}, got {value & 0xFF}")
        if pack == "?" and self._bytes[self._pos] > 1:
            raise WireError(f"expected 0 or 1 at {self._pos}, got {self._bytes[self._pos]}")
        self._pos += size
        return value

    def read_multi(self, pack: str, size: int) -> Any:
        self._check(size)
        return super().read_multi(pack, size)

    def read_bytes(self, length: int) -> bytes:
        self._check(length)
        return bytes(super().read_bytes(length))

    def check_end(self) -> None:
        rest = bytes(self._bytes[self._pos :])
        if any(rest) or len(rest) >= _WORD_BYTES or (rest and self._size % _WORD_BYTES):
            raise WireError(f"expected the end at {self._pos}, got {len(rest)} more bytes")

    def _check(self, size: int) -> None:
        if not 0 <= size <= self._size - self._pos:
            raise WireError(f"expected {size} bytes at {self._pos}, got {max(self._size - self._pos, 0)}")


def _printable(character: str) -> str:
    return character if character.isprintable() else character.encode("unicode_escape").decode()


def _what_does_not_fit(error: BaseException) -> str:
    """The field's path and the reason; pycdr2 wraps the reason once for every level, each time naming a member."""
    path = []
    while error.__cause__ is not None:
        path.append(str(error).partition(",")[0].rpartition(" ")[2])
        error = error.__cause__
    return f"{'.'.join(path)}: expected a value that the field can hold: {str(error) or type(error).__name__}"
