# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Any message of any type, for hypothesis, and the same message as rosbags has it."""

from __future__ import annotations

from dataclasses import fields
from functools import lru_cache
from typing import Any

import numpy as np
from hypothesis import strategies as st
from pycdr2.types import array, sequence, typedef

from edgefusion.messages import Message, ros_name
from edgefusion.messages.idl import byte

NUMBERS = {
    "uint8": st.integers(0, 2**8 - 1),
    "uint32": st.integers(0, 2**32 - 1),
    "int32": st.integers(-(2**31), 2**31 - 1),
    "float32": st.floats(width=32),
    "float64": st.floats(),
}
PLAIN = {bool: st.booleans(), str: st.text(max_size=8), bytes: st.binary(max_size=9)}


@lru_cache(maxsize=None)
def any_message(cls: type[Message]) -> st.SearchStrategy[Message]:
    """A message of that type, whatever is in it."""
    return st.builds(cls, **{field.name: _any_value(meaning(field.type)) for field in fields(cls)})


def meaning(annotation: Any) -> Any:
    """A class, the name of a number, a sequence or an array."""
    kind = getattr(annotation, "__metadata__", (annotation,))[0]
    return meaning(kind.subtype) if isinstance(kind, typedef) else kind


def _any_value(kind: Any) -> st.SearchStrategy[Any]:
    if isinstance(kind, sequence):
        return st.lists(_any_value(meaning(kind.subtype)), max_size=3)
    if isinstance(kind, array):
        # One value for all: dozens of them would use up what hypothesis tries for one example.
        value = _any_value(meaning(kind.subtype))
        return st.builds(lambda one, last: [one] * (kind.length - 1) + [last], value, value)
    if isinstance(kind, str):
        return NUMBERS[kind]
    return PLAIN[kind] if kind in PLAIN else any_message(kind)


def as_rosbags(message: Message, store: Any) -> Any:
    """The message in the types of a store of rosbags."""
    values = {field.name: _as_rosbags(getattr(message, field.name), field.type, store) for field in fields(message)}
    return store.types[ros_name(type(message))](**values)


def _as_rosbags(value: Any, annotation: Any, store: Any) -> Any:
    kind = meaning(annotation)
    if annotation == byte:
        return value - 2**8 if value > 127 else value  # rosbags counts an octet from -128
    if isinstance(kind, (sequence, array)):
        inner = meaning(kind.subtype)
        if isinstance(inner, str):
            return np.array(value, inner)
        return [_as_rosbags(each, inner, store) for each in value]
    if kind is bytes:
        return np.frombuffer(value, np.uint8)
    return as_rosbags(value, store) if isinstance(value, Message) else value
