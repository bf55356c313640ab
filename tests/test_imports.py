# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who may import whom: perception stands alone, tools come last, and the command line loads lazily."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import edgefusion

PACKAGE = Path(edgefusion.__file__).parent
CORE = {"types", "errors", "clock", "config", "pose_history", "waiting", "_core"}
ALLOWED = {
    "errors": set(),
    "types": {"errors"},
    "clock": {"types", "errors"},
    "waiting": {"clock"},
    "config": {"types", "errors"},
    "pose_history": {"types", "errors"},
    "perception": CORE | {"data"},
    "navigation": CORE,
    "drivers": CORE - {"_core"},
    "messages": {"types", "errors"},
    "bus": {"messages", "types", "errors", "clock", "config", "waiting"},
    "recording": {"messages", "types", "errors"},
    "sim": CORE | {"drivers"},
    "service": None,  # everything
    "tools": None,
    "cli": {"errors", "service", "tools"},
    "": {"bus"},  # edgefusion/__init__.py
}
MODULES = sorted(PACKAGE.rglob("*.py"))


def part_of(path: Path) -> str:
    """The folder or module directly below the package."""
    first = path.relative_to(PACKAGE).parts[0]
    return "" if first == "__init__.py" else first.replace(".py", "")


def imported_parts(path: Path) -> set[str]:
    parts = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        parts |= {name.split(".")[1] for name in names if name.startswith("edgefusion.")}
    return parts - {"__version__"}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_every_module_imports_only_what_its_part_may(path: Path) -> None:
    part = part_of(path)
    assert part in ALLOWED, f"say in ALLOWED what {part} may import"
    if ALLOWED[part] is not None:
        assert imported_parts(path) - {part} <= ALLOWED[part]


def test_the_command_line_loads_neither_the_core_nor_the_runtime_before_a_verb_runs() -> None:
    code = (
        "import sys; from edgefusion.cli import build_parser; build_parser(); "
        "print([m for m in ('edgefusion._core', 'onnxruntime', 'cv2', 'numpy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_base_loads_neither_the_runtime_nor_opencv_also_where_it_keeps_pictures() -> None:
    code = "import sys, edgefusion.service.base_process; print([m for m in ('onnxruntime', 'cv2') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
