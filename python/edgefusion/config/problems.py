# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""All that is wrong with a configuration, each with its key, what was expected and what came."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Mapping, Tuple, Type

import msgspec

from edgefusion.config.documentation import Path, is_section
from edgefusion.config.words import in_words, toml_value

_LONGEST = 60
_BARE = re.compile(r"[A-Za-z0-9_-]{1,60}")
_CONTROLS = re.compile(r"[\x00-\x1f\x7f]")
"""No name of anything has them, and they would go into logs and terminals."""


@dataclass(frozen=True)
class Problem:
    """path: of the key or section. reason: without it. named: keys in the file that the reason of a section names."""

    path: Path
    reason: str
    named: Tuple[Path, ...] = ()

    def __str__(self) -> str:
        return f"{'.'.join(map(_name, self.path))}: {self.reason}" if self.path else self.reason


def problems(content: Any, kind: Type[msgspec.Struct], path: Path = ()) -> List[Problem]:
    """Of the content of a TOML file, or of a section of it: first its keys, then what they are together."""
    if not isinstance(content, dict):
        return [Problem(path, f"expected a table, got {_shown(content)}")]
    fields = {field.name: field for field in msgspec.structs.fields(kind)}
    found = [Problem((*path, name), _unknown(name, fields)) for name in content if name not in fields]
    for name, field in fields.items():
        if name in content:
            found += _of_key(content[name], field.type, (*path, name))
    return found or _together(content, kind, path)


def line_of(problem: Problem, lines: Mapping[Path, int]) -> int | None:
    """The line of its key; of what keys are together, that of the first that is named, else the section's. None where
    nothing of it is in the file."""
    outwards = [problem.path[:size] for size in range(len(problem.path), 0, -1)]
    return next((lines[path] for path in (*problem.named, *outwards) if path in lines), None)


def _of_key(value: Any, kind: Any, path: Path) -> List[Problem]:
    if is_section(kind):
        return problems(value, kind, path)
    try:
        msgspec.convert(value, kind)
    except (msgspec.ValidationError, OverflowError, RecursionError):
        return [Problem(path, f"expected {in_words(kind)}, got {_shown(value)}")]
    if any(_CONTROLS.search(text) for text in _texts(value)):
        return [Problem(path, f"expected no control characters, got {_shown(value)}")]
    return []


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, list):
        for each in value:
            yield from _texts(each)


def _together(content: Dict[str, Any], kind: Type[msgspec.Struct], path: Path) -> List[Problem]:
    try:
        msgspec.convert(content, kind)
    except (msgspec.ValidationError, OverflowError, RecursionError) as error:
        named = (tuple(name.split(".")) for name in re.findall(r"\w[\w.]*\w", str(error)))
        return [Problem(path, str(error), tuple((*path, *name) for name in named if _is_in(content, name)))]
    return []


def _is_in(content: Any, path: Path) -> bool:
    for name in path:
        if not isinstance(content, dict) or name not in content:
            return False
        content = content[name]
    return True


def _unknown(name: str, fields: Mapping[str, Any]) -> str:
    near = difflib.get_close_matches(name, fields, 1)
    return "unknown key" + (f", did you mean {near[0]}?" if near else "")


def _name(key: str) -> str:
    """As TOML writes it: it may hold anything."""
    return key if _BARE.fullmatch(key) else _shown(key)


def _shown(value: Any) -> str:
    try:
        shown = toml_value(value)
    except (TypeError, ValueError, RecursionError):  # a date, or a number too long for Python to print
        shown = f"a {type(value).__name__}"
    return shown if len(shown) <= _LONGEST else f"{shown[:_LONGEST]} ..."
