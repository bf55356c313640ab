# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Every key of the configuration with what is said of it, out of the structures that read it.

A key's text is the docstring under it, a section's its class's. The unit is in the key's name, or in brackets at the
end of its text.
"""

from __future__ import annotations

import ast
import inspect
import re
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple, Type

import msgspec

from edgefusion.config.words import in_words

Path = Tuple[str, ...]
"""Of a key or section: its names from the outermost on."""

_UNITS = {
    "m": "m",
    "mm": "mm",
    "s": "s",
    "v": "V",
    "hz": "Hz",
    "mps": "m/s",
    "mmps": "mm/s",
    "mps2": "m/s^2",
    "radps": "rad/s",
    "radps2": "rad/s^2",
    "bytes": "bytes",
}
_UNIT = re.compile(r" ?\[([^\]]+)\]$")


@dataclass(frozen=True)
class Key:
    """kind: what it may be, in words. unit: empty where it has none. default: None where it is left out."""

    path: Path
    text: str
    kind: str
    unit: str
    default: Any

    @property
    def takes(self) -> str:
        """What it may be, and in which unit."""
        return f"{self.kind} [{self.unit}]" if self.unit else self.kind


@dataclass(frozen=True)
class Section:
    """path: empty for what is outside of any section."""

    path: Path
    text: str
    keys: Tuple[Key, ...]


def sections(kind: Type[msgspec.Struct], path: Path = ()) -> List[Section]:
    """In the order of their fields; a section within another follows it."""
    texts = _texts_of_fields(kind)
    keys: List[Key] = []
    within: List[Section] = []
    for field in msgspec.structs.fields(kind):
        at = (*path, field.name)
        if is_section(field.type):
            within += sections(field.type, at)
        else:
            keys.append(_key(at, field, texts.get(field.name, "")))
    return [Section(path, _one_line(kind.__doc__ or ""), tuple(keys)), *within]


def is_section(kind: Any) -> bool:
    """Whether it is the type of a section, not of a key."""
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)


def _key(path: Path, field: msgspec.structs.FieldInfo, text: str) -> Key:
    bracketed = _UNIT.search(text)
    unit = bracketed.group(1) if bracketed else _UNITS.get(path[-1].rpartition("_")[2], "")
    return Key(path, _UNIT.sub("", text), in_words(field.type), unit, msgspec.to_builtins(field.default))


def _texts_of_fields(kind: Type[msgspec.Struct]) -> Dict[str, str]:
    """What stands below each field as a string of its own."""
    (definition,) = ast.parse(inspect.getsource(kind)).body
    assert isinstance(definition, ast.ClassDef)
    texts = {}
    for field, below in zip(definition.body, definition.body[1:]):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(below, ast.Expr):
            texts[field.target.id] = _one_line(str(ast.literal_eval(below.value)))
    return texts


def _one_line(text: str) -> str:
    return " ".join(text.split())
