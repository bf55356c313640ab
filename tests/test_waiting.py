# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Waits whose length no step of the wall clock changes: the robot knows no others (S2 of the fault figures)."""

from __future__ import annotations

import ast
import threading
import time
from pathlib import Path
from typing import Iterator

import pytest

import edgefusion
from edgefusion.waiting import Wake, join

PACKAGE = Path(edgefusion.__file__).parent
ROBOT = ("bus", "drivers", "service", "navigation", "perception")
BY_THE_WALL_CLOCK = {"Event", "Condition", "Timer", "Semaphore", "BoundedSemaphore", "Barrier"}
"""Of threading; before Python 3.11, and with the C library of a Jetson, a timeout of theirs is a time of day."""


def waits_by_the_wall_clock(source: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if (
            isinstance(node, ast.Attribute)
            and ast.unparse(node.value) == "threading"
            and node.attr in BY_THE_WALL_CLOCK
        ):
            yield ast.unparse(node)
        if isinstance(node, ast.ImportFrom) and node.module == "threading":
            yield ast.unparse(node)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and (node.args or node.keywords):
            owner, method = ast.unparse(node.func.value).lower(), node.func.attr
            if (owner.endswith("thread") and method == "join") or (owner.endswith("future") and method == "result"):
                yield ast.unparse(node)
            if method in ("acquire", "get", "put") and owner.endswith(("queue", "lock", "waiting")):
                yield from (ast.unparse(node) for keyword in node.keywords if keyword.arg == "timeout")


@pytest.mark.skipif(not hasattr(ast, "unparse"), reason="the older Python cannot print what it parsed")
def test_nothing_on_the_robot_waits_by_the_wall_clock() -> None:
    bad = (
        "threading.Event()", "from threading import Condition", "self._thread.join(2.0)", "future.result(timeout_s)",
        "self._waiting.get(timeout=1.0)", "lock.acquire(timeout=1)",
    )  # fmt: skip
    assert all(list(waits_by_the_wall_clock(text)) for text in bad)
    modules = [path for part in ROBOT for path in sorted((PACKAGE / part).rglob("*.py"))]
    found = {str(path): list(waits_by_the_wall_clock(path.read_text(encoding="utf-8"))) for path in modules}
    assert {path: waits for path, waits in found.items() if waits} == {}


def test_a_wait_lasts_as_long_as_it_is_to_and_ends_early_when_it_is_called() -> None:
    wake, began_s = Wake(), time.monotonic()
    assert not wake.wait(0.02)
    assert time.monotonic() - began_s >= 0.02
    wake()
    assert wake.wait(100)


def test_a_thread_that_does_not_end_is_waited_for_until_then_and_no_longer() -> None:
    free, now_ns = threading.Event(), [0]
    thread = threading.Thread(target=free.wait)
    assert join(thread, 1.0)  # it never began

    def pause(seconds: float) -> None:
        now_ns[0] += round(seconds * 1e9)

    thread.start()
    assert not join(thread, 1.5, lambda: now_ns[0], pause)
    assert now_ns[0] == pytest.approx(1.5e9, rel=0.01)
    free.set()
    assert join(thread, 100.0)
