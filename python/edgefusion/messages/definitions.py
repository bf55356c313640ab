# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The definitions of messages as ROS 2's .msg files state them, for recordings and for tools that do not know them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Iterator

from pycdr2.types import array, sequence, typedef

from edgefusion.messages.idl import Message, ros_name

_SEPARATOR = "=" * 80
_PLAIN = {bool: "bool", str: "string", bytes: "uint8[]"}


def definition(cls: type[Message]) -> str:
    """The type's definition followed by those of all that it contains, in MCAP's encoding "ros2msg"."""
    contained = [f"{_SEPARATOR}\nMSG: {_short(each)}\n{_own(each)}" for each in _contained(cls)]
    return "\n".join([_own(cls), *contained])


def _own(cls: type[Message]) -> str:
    """Constants and fields, one a line."""
    members = [(_ros_type(field.type), field.name) for field in fields(cls)]  # type: ignore[arg-type]
    # Where a type has constants, they are values of its numbers, which are all alike.
    number = next((ros for ros, _ in members if ros.startswith(("int", "uint", "byte"))), "")
    constants = [f"{number} {name}={value}" for name, value in vars(cls).items() if name.isupper()]
    return "\n".join([*constants, *(f"{ros} {name}" for ros, name in members)])


def _contained(cls: type[Message]) -> list[type[Message]]:
    """Every type below this one, once, before what it contains itself."""
    found: dict[type[Message], None] = {}
    for inner in _inner(cls):
        found.update(dict.fromkeys([inner, *_contained(inner)]))
    return list(found)


def _inner(cls: type[Message]) -> Iterator[type[Message]]:
    """The types of the fields that are messages, or sequences of them."""
    for field in fields(cls):  # type: ignore[arg-type]
        kind = _meaning(field.type)
        kind = kind.subtype if isinstance(kind, sequence) else kind
        if isinstance(kind, type) and issubclass(kind, Message):
            yield kind


def _ros_type(annotation: Any) -> str:
    kind = _meaning(annotation)
    if isinstance(kind, sequence):
        return f"{_ros_type(kind.subtype)}[]"
    if isinstance(kind, array):
        return f"{_ros_type(kind.subtype)}[{kind.length}]"
    if isinstance(kind, typedef):
        return kind.name
    if isinstance(kind, str):
        return kind
    return _PLAIN.get(kind) or _short(kind)


def _meaning(annotation: Any) -> Any:
    """What pycdr2 takes an annotation for: a class, the name of a number, or what stands for several."""
    return getattr(annotation, "__metadata__", (annotation,))[0]


def _short(cls: type[Message]) -> str:
    """As in a .msg file: "std_msgs/Header"."""
    return ros_name(cls).replace("/msg/", "/")
