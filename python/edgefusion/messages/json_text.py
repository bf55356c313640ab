# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Strict JSON in a String: an unknown or a missing field, a wrong type or another version is refused."""

from __future__ import annotations

import math
from typing import Optional, Type, TypeVar

import msgspec

from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import WireError
from edgefusion.messages.std_msgs import String

S = TypeVar("S", bound=msgspec.Struct)

MOST_CHARACTERS = 1 << 22


def to_text(content: msgspec.Struct) -> String:
    """The structure as JSON."""
    return String(msgspec.json.encode(content).decode())


def from_text(message: String, kind: Type[S], name: str) -> S:
    """The structure. Raises WireError, naming what it is of, for what is not exactly that."""
    if len(message.data) > MOST_CHARACTERS:
        raise WireError(f"{name}: expected at most {MOST_CHARACTERS} characters, got {len(message.data)}")
    try:
        return msgspec.json.decode(message.data, type=kind)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise WireError(f"{name}: {error}") from None


def number(value: float, name: str) -> float:
    """JSON has finite numbers only. Raises RefusedError for another."""
    if not math.isfinite(value):
        raise RefusedError(f"{name}: expected a finite number, got {value}")
    return float(value)


def number_or_none(value: float) -> Optional[float]:
    """None for infinity and NaN, where JSON has nothing else to say it with."""
    return float(value) if math.isfinite(value) else None
