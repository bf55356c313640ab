# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Groups of labels: a user asks for a "car", and ImageNet answers sports car, minivan or beach wagon."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Dict, Iterator, Literal, Mapping, Sequence, Tuple

import msgspec

from edgefusion.config import convert, read_toml
from edgefusion.errors import RefusedError

DEFAULT_PATH = Path(__file__).resolve().parents[1] / "data" / "groups.toml"


class _GroupsFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    version: Literal[1]
    groups: Dict[str, Tuple[str, ...]]


class LabelGroups:
    """Named groups of labels. A label belongs to at most one; a group may name labels that a model lacks."""

    def __init__(self, groups: Mapping[str, Sequence[str]]) -> None:
        """Raises RefusedError: an empty group or name, a label twice, a group named like another's label."""
        self._labels = {name: tuple(labels) for name, labels in groups.items()}
        self._group: dict[str, str] = {}
        for name, labels in self._labels.items():
            self._add(name, labels)
        for name in self._labels:
            # Else the name would mean the group to labels_of, and the other group to group_of.
            if self.group_of(name) not in ("", name):
                raise RefusedError(f"group {name!r}: is also a label of the group {self.group_of(name)!r}")

    @classmethod
    def load(cls, path: Path | None = None) -> LabelGroups:
        """The groups of a TOML file, or edgefusion's own. Raises RefusedError naming the file."""
        path = path or DEFAULT_PATH
        content = convert(read_toml(path), _GroupsFile, path)
        try:
            return cls(content.groups)
        except RefusedError as error:
            raise RefusedError(f"{path}: {error}") from error

    def __iter__(self) -> Iterator[str]:
        """The names of the groups, in the file's order."""
        return iter(self._labels)

    def group_of(self, label: str) -> str:
        """The group that a label belongs to, or ""."""
        return self._group.get(label, "")

    def labels_of(self, name: str, model_labels: Sequence[str] | None = None) -> tuple[str, ...]:
        """The labels that a user means by the name of a group or of a single label.

        model_labels: what the model can answer; None: the labels of all groups. Of a group, the labels that the
        model has, in the file's order. Raises RefusedError with the names that come closest, where the model can
        answer nothing by that name.
        """
        known = set(self._group if model_labels is None else model_labels)
        meant = tuple(label for label in self._labels.get(name, (name,)) if label in known)
        if not meant:
            raise RefusedError(f"{name!r}: no label or group of the model{self._hint(name, known)}")
        return meant

    def _add(self, name: str, labels: tuple[str, ...]) -> None:
        if not name or not labels or not all(labels):
            raise RefusedError(f"group {name!r}: expected a name and at least one label, none of them empty")
        for label in labels:
            if label in self._group:
                raise RefusedError(f"group {name!r}: {label!r} is already in the group {self._group[label]!r}")
            self._group[label] = name

    def _hint(self, name: str, known: set[str]) -> str:
        """Names like this one: those that hold its words first ("couch": studio couch), then misspellings."""
        groups = {group for group, labels in self._labels.items() if known.intersection(labels)}
        names = {each.lower(): each for each in sorted(known | groups)}
        asked = name.lower().strip()
        holding = [each for each in names if asked and f" {asked} " in f" {each} "]
        close = difflib.get_close_matches(asked, names, n=3)
        nearest = list(dict.fromkeys(names[each] for each in holding + close))[:3]
        return f"; did you mean {', '.join(nearest)}?" if nearest else ""
