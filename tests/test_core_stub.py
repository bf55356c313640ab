# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The typed stub tells the truth about the compiled core."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import edgefusion
from edgefusion import _core

STUB = ast.parse((Path(edgefusion.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))
FUNCTIONS = {node.name: node for node in reversed(STUB.body) if isinstance(node, ast.FunctionDef)}


def test_the_stub_names_all_that_the_core_has_and_nothing_else() -> None:
    names = set(FUNCTIONS) | {node.name for node in STUB.body if isinstance(node, ast.ClassDef)}
    names |= {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
    assert names == {name for name in dir(_core) if not name.startswith("__")}


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_the_stub_has_the_cores_arguments_in_their_order(name: str) -> None:
    # pybind11 writes every signature into the docstring, "name(a: type, b: type = value) -> type".
    signatures = re.findall(rf"{name}\((.*)\) ->", getattr(_core, name).__doc__)
    arguments = [argument.arg for argument in FUNCTIONS[name].args.args]
    assert arguments in [re.findall(r"(\w+): ", re.sub(r"typing\.\w+\[[^]]*\]", "x", s)) for s in signatures]


def test_the_core_describes_the_camera_as_the_stub_does() -> None:
    camera = next(node for node in STUB.body if isinstance(node, ast.ClassDef))
    methods = {node.name for node in camera.body if isinstance(node, ast.FunctionDef)} - {"__init__"}
    assert methods == {name for name in dir(_core.Camera) if not name.startswith("_")}
