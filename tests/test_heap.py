# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a process gives back of the memory that it has once held."""

from __future__ import annotations

import ctypes
import subprocess
import sys

import pytest

HOLDS = """
import sys
from ctypes import CDLL, c_size_t, c_void_p, memset
from pathlib import Path
from edgefusion.service.heap import give_back_early

assert sys.argv[1] == "not" or give_back_early()
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


def grown_mb(how: str) -> float:
    return float(subprocess.run([sys.executable, "-c", HOLDS, how], check=True, stdout=subprocess.PIPE).stdout)


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="glibc's settings, this is another C library")
def test_pictures_that_are_freed_go_back_to_the_system_which_they_do_not_by_themselves() -> None:
    assert grown_mb("not") > 40
    assert grown_mb("early") < 5
