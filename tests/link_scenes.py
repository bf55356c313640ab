# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A port that can be unplugged, and links to it."""

from __future__ import annotations

import os
import tty
from pathlib import Path

import pytest

from edgefusion.drivers.link import Link

MS = 1_000_000


class Pty:
    """A port to open (path), and the device's end of it (master)."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.plug_in()

    def plug_in(self) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.path.symlink_to(os.ttyname(self.slave))

    def unplug(self) -> None:
        os.close(self.master)
        os.close(self.slave)
        self.path.unlink()


@pytest.fixture
def pty(tmp_path):
    made = Pty(tmp_path / "ttyROBOT")
    yield made
    if made.path.is_symlink():
        made.unplug()


@pytest.fixture
def make_link(tmp_path):
    made = []

    def make(name, **settings):
        made.append(Link(str(name), 9600, lock_folder=tmp_path, **settings))
        return made[-1]

    yield make
    for link in made:
        link.close()
