# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a process that a supervisor starts gives back of the memory that it has once held."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from typing import Mapping

import pytest

from base_lab import wait_for
from edgefusion.service.child_process import ChildProcess
from edgefusion.service.child_spec import ChildSpec
from edgefusion.service.heap import ENVIRONMENT

HOLDS = """
from ctypes import CDLL, c_size_t, c_void_p, memset
from pathlib import Path

libc = CDLL(None)
libc.malloc.restype, libc.malloc.argtypes, libc.free.argtypes = c_void_p, [c_size_t], [c_void_p]

def resident_mb():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6

def held(size):
    piece = libc.malloc(size)
    memset(piece, 1, size)
    return piece

libc.free(held(8_000_000))  # from then on glibc takes pieces below it from what it keeps
before = resident_mb()
pieces = [held(1_000_000) for _ in range(50)]
pin = held(100_000)
for piece in pieces:
    libc.free(piece)
print(resident_mb() - before)
"""


def grown_mb(environment: Mapping[str, str]) -> float:
    there = {name: value for name, value in os.environ.items() if name not in ENVIRONMENT}
    command = [sys.executable, "-c", HOLDS]
    return float(subprocess.run(command, env={**there, **environment}, check=True, stdout=subprocess.PIPE).stdout)


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="glibc's settings, this is another C library")
def test_pictures_that_are_freed_go_back_to_the_system_which_they_do_not_by_themselves() -> None:
    assert grown_mb({}) > 40
    assert grown_mb(ENVIRONMENT) < 5


@pytest.mark.parametrize(("users", "its"), [({}, "2"), ({"MALLOC_ARENA_MAX": "7"}, "7")])
def test_every_child_begins_with_these_settings_but_for_those_that_its_user_made(users, its: str) -> None:
    says = f"import os, sys; sys.exit(os.environ['MALLOC_ARENA_MAX'] == '{its}')"
    child = ChildProcess(ChildSpec("any", (sys.executable, "-c", says), 60.0, 60.0), users)
    wait_for(lambda: child.poll() is not None)
    child.close()
    assert child.poll() == 1
