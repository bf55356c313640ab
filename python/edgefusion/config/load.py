# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From a TOML file to the configuration, or to what is wrong with it, line by line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Generic, List, Type, TypeVar

import msgspec
from msgspec import inspect as types

from edgefusion.config.documentation import Path as KeyPath
from edgefusion.config.documentation import is_section
from edgefusion.config.problems import line_of, problems
from edgefusion.config.strict import parse_toml, read_text
from edgefusion.config.toml_lines import key_lines
from edgefusion.errors import RefusedError

T = TypeVar("T", bound=msgspec.Struct)


@dataclass(frozen=True)
class Loaded(Generic[T]):
    """lines: where each key and section of the file is."""

    config: T
    lines: Dict[KeyPath, int]


class ConfigError(RefusedError):
    """complaints: all that is wrong, each with file, line and reason; the message is the first."""

    def __init__(self, path: Path, complaints: List[str]) -> None:
        more = f" (and {len(complaints) - 1} more: edgefusion config check {path})" if complaints[1:] else ""
        super().__init__(complaints[0] + more)
        self.complaints = complaints


def load(path: Path, kind: Type[T]) -> Loaded[T]:
    """Files that it names are relative to its folder. Raises ConfigError, RefusedError where it is no TOML."""
    text = read_text(path)
    content = parse_toml(text, path)
    try:
        found, lines = problems(content, kind), key_lines(text)
    except RecursionError:
        raise RefusedError(f"{path}: expected sections and keys, got tables within tables without end") from None
    if found:
        at = [(line_of(problem, lines), problem) for problem in found]
        at.sort(key=lambda each: each[0] or 0)
        raise ConfigError(path, [f"{path}:{line}: {problem}" if line else f"{path}: {problem}" for line, problem in at])
    return Loaded(msgspec.convert(_with_files_beside(content, kind, path.parent), kind), lines)


def _with_files_beside(content: Dict[str, Any], kind: Type[msgspec.Struct], folder: Path) -> Dict[str, Any]:
    result = dict(content)
    for field in msgspec.structs.fields(kind):
        if field.name not in content:
            continue
        if is_section(field.type):
            result[field.name] = _with_files_beside(content[field.name], field.type, folder)
        elif _is_file(types.type_info(field.type)):
            result[field.name] = str(folder / content[field.name])
    return result


def _is_file(kind: types.Type) -> bool:
    if isinstance(kind, types.UnionType):
        return any(_is_file(each) for each in kind.types)
    return isinstance(kind, types.Metadata) and bool((kind.extra or {}).get("file"))
