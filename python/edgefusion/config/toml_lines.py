# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""In which line of a TOML file each key is: the parser itself says where a statement ends."""

from __future__ import annotations

import sys
from typing import Any, Dict, Iterator

from edgefusion.config.documentation import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


_ENDS = ("]", "}", '"""', "'''")
"""One of these is in the last line of a statement of several."""


def key_lines(text: str) -> Dict[Path, int]:
    """The line, from 1 on, in which each key and table of a valid TOML text first begins."""
    lines: Dict[Path, int] = {}
    table: Path = ()
    statement, begin = "", 1
    for number, line in enumerate(text.split("\n"), 1):
        is_first, statement = not statement, statement + line + "\n"
        if not is_first and not any(end in line for end in _ENDS):
            continue  # else a list of thousands of lines would be parsed thousands of times
        try:
            found = list(_paths(tomllib.loads(statement)))
        except tomllib.TOMLDecodeError:  # its array or string goes on
            continue
        is_header = statement.lstrip(" \t").startswith("[")
        for path in found:
            lines.setdefault(path if is_header else (*table, *path), begin)
        if is_header:
            table = found[-1]
        statement, begin = "", number + 1
    return lines


def _paths(content: Any) -> Iterator[Path]:
    """Of every key, outer ones first; tables of an array share one."""
    if isinstance(content, list):
        for item in content:
            yield from _paths(item)
    if isinstance(content, dict):
        for name, value in content.items():
            yield (name,)
            yield from ((name, *path) for path in _paths(value))
