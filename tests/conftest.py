# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the tests share: the real data beside the project, where a machine has it, and a bus."""

from __future__ import annotations

import os
import signal
from contextlib import ExitStack
from pathlib import Path
from typing import Iterator

import pytest
from hypothesis import settings

from bus_lab import Lab

# No test depends on how fast the machine is; CI tries the same examples every time, people new ones.
settings.register_profile("edgefusion", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("edgefusion")

# What a shell puts in the background, or nohup starts, ignores these, and all that the tests start would inherit it.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings and models; tests that need it skip where it is absent."""
    if not SHARED_DATA.is_dir():
        pytest.skip("the real data (../shared/data) is not on this machine")
    return SHARED_DATA


@pytest.fixture
def lab() -> Iterator[Lab]:
    """A router on a port of its own, and what joins it."""
    with ExitStack() as stack:
        lab = Lab(stack)
        lab.router()
        yield lab
