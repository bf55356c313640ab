# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the tests of faults share."""

from __future__ import annotations

from pathlib import Path

import pytest
from virtual_base import VirtualBase


@pytest.fixture
def base(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """Makes a base in virtual time: base(seed, baudrate)."""
    monkeypatch.locks = tmp_path

    def make(seed: int = 0, baudrate: int = 500000) -> VirtualBase:
        return VirtualBase(monkeypatch, seed, baudrate)

    return make
