# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a key of the configuration may be, in words, out of its type: for the reference and for refusals alike."""

from __future__ import annotations

import json
from typing import Any, List, Optional, Union

from msgspec import inspect as types

_NUMBERS = {types.IntType: "a whole number", types.FloatType: "a number"}
_BOUNDS = (("ge", "at least"), ("gt", "above"), ("le", "at most"), ("lt", "below"))
_PLURALS = {"a number": "numbers", "a whole number": "whole numbers", "text": "texts"}


def toml_value(value: Any) -> str:
    """A value as TOML writes it; JSON writes everything that is in a configuration the same way."""
    return json.dumps(value, ensure_ascii=False)


def in_words(kind: Any) -> str:
    """What a type takes, as "a number above 0, at most 10" of a msgspec type or an annotation."""
    return _words(kind if isinstance(kind, types.Type) else types.type_info(kind))


def _words(kind: types.Type) -> str:
    if isinstance(kind, types.Metadata):
        return _words(kind.type)
    if isinstance(kind, (types.IntType, types.FloatType)):
        return _NUMBERS[type(kind)] + _limits(kind)
    if isinstance(kind, types.LiteralType):
        return _either([toml_value(value) for value in kind.values])
    if isinstance(kind, types.UnionType):
        return _either([_words(each) for each in kind.types if not isinstance(each, types.NoneType)])
    if isinstance(kind, types.VarTupleType):
        return f"a list of {_count(kind.min_length, kind.max_length)}{_many(kind.item_type)}"
    if isinstance(kind, types.TupleType):
        return f"a list of {len(kind.item_types)} {_many(kind.item_types[0])}"
    if isinstance(kind, types.StrType):
        return f"text like {kind.pattern}" if kind.pattern else f"text{_length(kind.min_length or 0, kind.max_length)}"
    return {types.BoolType: "true or false", types.StructType: "a table"}[type(kind)]


def _limits(kind: Union[types.IntType, types.FloatType]) -> str:
    if kind.ge is not None and kind.le is not None:
        return f" from {_number(kind.ge)} to {_number(kind.le)}"
    bounds = [f"{name} {_number(getattr(kind, bound))}" for bound, name in _BOUNDS if getattr(kind, bound) is not None]
    return " " + ", ".join(bounds) if bounds else ""


def _number(value: Union[int, float]) -> str:
    return str(value) if isinstance(value, int) else f"{value:g}"


def _either(choices: List[str]) -> str:
    *others, last = choices
    return f"{', '.join(others)} or {last}" if others else last


def _count(least: Optional[int], most: Optional[int]) -> str:
    if most is None:
        return f"at least {least} " if least else ""
    return f"{least or 0} to {most} "


def _length(least: int, most: Optional[int]) -> str:
    if most is None:
        return f" of {least} or more characters" if least else ""
    return f" of {least} to {most} characters" if least else f" of at most {most} characters"


def _many(kind: types.Type) -> str:
    """Of the items of a list."""
    one = _words(kind)
    for singular, plural in _PLURALS.items():
        if one.startswith(singular):
            return plural + one[len(singular) :]
    return f"lists, each {one}" if one.startswith("a list") else f"values, each {one}"
