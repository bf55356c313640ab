# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The benchmark of lateness: what it calls met, missed and broken, and that it can take a privilege away."""

from __future__ import annotations

import subprocess
import sys

import pytest
from benchmarks.lateness import cells, is_broken
from benchmarks.lateness_rig import Load, unprivileged

from edgefusion.errors import RefusedError

ASKS = """
import os
try:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(5))
except OSError:
    print("refused")
"""


def load(p99: float, real_time: int = 3, busy: float = 0.99) -> Load:
    return Load(
        1240, 0.2, p99, 2 * p99, real_time, {"vision": 1.5}, busy, {"frames [Hz]": "8.0", "infer [ms]": "101.0"}
    )


@pytest.mark.parametrize(
    ("name", "p99", "word"),
    [
        ("unprivileged", 24.9, "met"),
        ("unprivileged", 74.0, "missed"),
        ("unprivileged", 76.0, "broken"),
        ("real time", 9.9, "met"),
        ("real time", 31.0, "broken"),
    ],
)
def test_only_what_no_load_explains_is_broken(name: str, p99: float, word: str) -> None:
    assert cells(name, load(p99))[-1] == word
    assert is_broken(name, load(p99)) is (word == "broken")


def test_real_time_that_a_machine_does_not_give_is_not_judged() -> None:
    assert cells("real time", load(300.0, real_time=0))[-1] == "not allowed here"
    assert not is_broken("real time", load(300.0, real_time=0))


def test_processors_that_had_nothing_to_do_are_no_test_of_lateness() -> None:
    assert cells("unprivileged", load(1.0, busy=0.9))[-1] == "met, but the processors were not full: a larger --model"


def test_what_is_begun_unprivileged_may_not_ask_for_real_time() -> None:
    try:
        wrapper = unprivileged()
    except RefusedError as error:
        pytest.skip(str(error))
    if not wrapper:
        pytest.skip("this user's limits are what they are")
    assert subprocess.run([*wrapper, sys.executable, "-c", ASKS], capture_output=True).stdout == b"refused\n"
