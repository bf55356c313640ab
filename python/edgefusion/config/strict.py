# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Strict TOML: an unknown key, a wrong type or an impossible value is refused with one line."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Type, TypeVar

import msgspec

from edgefusion.errors import RefusedError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib
if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

# Every number has an upper limit far above what makes sense: without one, infinity and typing errors get in.
UpTo1 = Annotated[float, msgspec.Meta(gt=0, le=1)]
UpTo10 = Annotated[float, msgspec.Meta(gt=0, le=10)]
UpTo100 = Annotated[float, msgspec.Meta(gt=0, le=100)]
Seconds = Annotated[float, msgspec.Meta(gt=0, le=60)]
Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Place = Annotated[str, msgspec.Meta(min_length=1, max_length=1024)]
FilePath = Annotated[str, msgspec.Meta(min_length=1, max_length=1024, extra={"file": True})]
"""In a file, it is relative to that file's folder."""
T = TypeVar("T")


def check_fields(settings: msgspec.Struct) -> None:
    """msgspec checks what comes from a file; this checks what is built in Python just as strictly."""
    for field in msgspec.structs.fields(settings):
        try:
            msgspec.convert(getattr(settings, field.name), field.type)
        except msgspec.ValidationError as error:
            raise RefusedError(f"{field.name}: {error}") from error


def read_text(path: Path) -> str:
    """The text of a TOML file. Raises RefusedError naming the file."""
    try:
        return path.read_text(encoding="utf-8-sig")  # some editors begin every file with a byte order mark
    except OSError as error:
        raise RefusedError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise RefusedError(f"{path}: not TOML: {error}") from error


def parse_toml(text: str, path: Path) -> dict[str, Any]:
    """Its content. Raises RefusedError naming the file, and the line where it is no TOML."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also of very long numbers
        raise RefusedError(f"{path}: not TOML: {error}") from error


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file. Raises RefusedError as both."""
    return parse_toml(read_text(path), path)


def convert(content: Any, kind: Type[T], path: Path) -> T:
    """Content of a file as a strict structure. Raises RefusedError naming the file, the key, what was expected."""
    try:
        return msgspec.convert(content, kind)
    except (msgspec.ValidationError, OverflowError, RecursionError) as error:
        raise RefusedError(f"{path}: {error}") from error
