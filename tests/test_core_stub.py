# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The typed stub tells the truth about the compiled core."""

from __future__ import annotations

import ast
import re
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import edgefusion
from edgefusion import _core

STUB = ast.parse((Path(edgefusion.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))
FUNCTIONS = {node.name: node for node in reversed(STUB.body) if isinstance(node, ast.FunctionDef)}
METHODS = {
    (node.name, method.name): method
    for node in STUB.body
    if isinstance(node, ast.ClassDef)
    for method in node.body
    if isinstance(method, ast.FunctionDef)
}


def test_the_stub_names_all_that_the_core_has_and_nothing_else() -> None:
    names = set(FUNCTIONS) | {name for name, _ in METHODS}
    names |= {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
    assert names == {name for name in dir(_core) if not name.startswith("__")}


def arguments_of(function: ast.FunctionDef) -> list[tuple[str, bool]]:
    """Every argument's name, and whether it has a default."""
    names = [argument.arg for argument in function.args.args]
    first_default = len(names) - len(function.args.defaults)
    return [(name, i >= first_default) for i, name in enumerate(names)]


def compiled_arguments(docstring: str, name: str) -> list[list[tuple[str, bool]]]:
    """The same of every overload: pybind11 writes "name(a: type, b: type = value) -> type" into the docstring."""
    signatures = re.findall(rf"{name}\((.*)\) ->", docstring)
    bare = [re.sub(r"[\w.]+\[[^]]*\]|'[^']*'|\(\)", "x", signature) for signature in signatures]
    return [[(name, bool(d)) for name, d in re.findall(r"(\w+): [\w. |]+?( = |(?=,|$))", text)] for text in bare]


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_the_stub_has_the_cores_arguments_in_their_order_and_their_defaults(name: str) -> None:
    compiled = compiled_arguments(getattr(_core, name).__doc__, name)
    stub = [arguments_of(node) for node in STUB.body if isinstance(node, ast.FunctionDef) and node.name == name]
    assert stub == compiled


def is_property(method: ast.FunctionDef) -> bool:
    return any(isinstance(mark, ast.Name) and mark.id == "property" for mark in method.decorator_list)


@pytest.mark.parametrize(("kind", "name"), sorted(METHODS))
def test_the_stub_has_the_methods_arguments_in_their_order_and_their_defaults(kind: str, name: str) -> None:
    compiled, method = getattr(getattr(_core, kind), name), METHODS[kind, name]
    assert isinstance(compiled, property) == is_property(method)
    if not is_property(method):
        assert [arguments_of(method)] == compiled_arguments(compiled.__doc__, name)


@pytest.mark.parametrize("kind", sorted({kind for kind, _ in METHODS}))
def test_the_stub_names_all_methods_that_a_class_has_and_nothing_else(kind: str) -> None:
    stub = {name for of, name in METHODS if of == kind} - {"__init__"}
    assert stub == {name for name in dir(getattr(_core, kind)) if not name.startswith("_")}


K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1]], float)
T_CAMERA_LASER = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]], float)
CAMERA = _core.Camera(K)
MANY = np.random.default_rng(0).uniform(1, 9, (50_000, 3))
TO_GROUND = [0, 0, -0.3]
FOOTPRINT = _core.Footprint([[0.2, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.2, -0.2]])
MAP = _core.ObstacleMap(0.05)
MAP.cover(0, 0, 5, 5)
FIELD = _core.NavigationFunction(0.2, 0.7, 4.0)
FIELD.begin(MAP, 5, 5, 0.05, 0, 0)
SEARCH = _core.Manoeuvre(FOOTPRINT)


def search() -> None:
    SEARCH.begin(MAP, FIELD, [0, 0, 0], 0.02, np.zeros((0, 2)), pose=[1.5, 1.5, 0])
    SEARCH.advance(MAP, FIELD, 300)


CALLS = {
    "dbscan": lambda: _core.dbscan(MANY[:, :2], 0.01, 3),
    "project": lambda: _core.project(MANY, CAMERA, T_CAMERA_LASER),
    "project_paper": lambda: _core.project_paper(MANY, K, 640, 480),
    "candidate_boxes": lambda: _core.candidate_boxes(
        MANY[:, 0], MANY[:, 1], 0.01, CAMERA, T_CAMERA_LASER, TO_GROUND, 640, 480, [1.0]
    ),
    "nearest_range": lambda: _core.nearest_range(MANY[:, 0], 0.01),
    "split_clusters": lambda: _core.split_clusters(MANY[:2000, :2], np.zeros(2000, int), 0.01, 0.3, 3),
    "raycast": lambda: _core.raycast(np.hstack([MANY[:, :2], MANY[:, :2] + 0.1]), [5, 5, 0], 0, 0.01, 600, 20),
    "crops": lambda: _core.crops(np.zeros((500, 500, 3), np.uint8), [[0, 0, 500, 500]] * 9, 256, [0] * 3, [1] * 3),
    "NavigationFunction.begin": lambda: FIELD.begin(MAP, 5, 5, 0.05, 0, 0),
    "NavigationFunction.advance": lambda: FIELD.advance(MAP, 20_000) or FIELD.begin(MAP, 5, 5, 0.05, 0, 0),
    "Manoeuvre.advance": search,
}


def test_all_functions_but_the_shortest_are_called_in_the_next_test() -> None:
    assert {name for name in CALLS if "." not in name} == set(FUNCTIONS) - {"followed"}


@pytest.mark.parametrize("name", sorted(CALLS))
def test_other_python_threads_run_meanwhile(name: str) -> None:
    go, advanced = threading.Lock(), threading.Event()
    go.acquire()

    def advance() -> None:
        go.acquire()
        advanced.set()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e5)  # nobody is made to give the lock up, so only a call that releases it lets others run
    try:
        thread = threading.Thread(target=advance)
        thread.start()
        go.release()
        assert not advanced.is_set()
        for _ in range(300):
            CALLS[name]()
            if advanced.is_set():
                break
        assert advanced.is_set()
    finally:
        sys.setswitchinterval(interval)
    thread.join()
