# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A fleet's keys in a folder: ca/, which stays where it was made, and for each machine a folder to be copied to it."""

from __future__ import annotations

import os
import shutil
from datetime import datetime
from pathlib import Path
from typing import Sequence

from edgefusion.bus import keys
from edgefusion.bus.key_files import CA_FILE, CERTIFICATE_FILE, KEY_FILE, ROLES
from edgefusion.bus.keys import Issued
from edgefusion.errors import RefusedError

CA_FOLDER = "ca"


def init(folder: Path, hosts: Sequence[str], until: datetime) -> list[Path]:
    """Makes a CA and one set of keys for each role, the robot's for these hosts and its own loopback.

    Gives the folders that are to be copied to machines. until: the end of all of them (UTC). Raises RefusedError for a
    folder that has something in it, and for hosts as `keys.issue`.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise RefusedError(f"{folder}: expected a new or empty folder: keys are never overwritten")
    every_host = list(dict.fromkeys((*hosts, *keys.LOCAL_HOSTS)))
    for host in every_host:
        keys.host_name(host)
    authority = keys.make_authority(until)
    _write(folder / CA_FOLDER, {CA_FILE: authority.certificate, KEY_FILE: authority.key})
    return [_issue_into(folder, authority, role, role, every_host if role == "robot" else ()) for role in ROLES]


def add(folder: Path, name: str, role: str) -> Path:
    """One more set of keys, from the CA of `init`; it lets in whoever has it, with no change on the robot.

    Raises RefusedError for a name that is taken or no file name, a role that is none, a folder without a CA.
    """
    if name != Path(name).name or name.startswith("."):
        raise RefusedError(f"name: expected one that a folder can have, got {name!r}")
    if (folder / name).exists():
        raise RefusedError(f"name: expected one that is not taken, got {name}: {folder / name} is there")
    return _issue_into(folder, _read_authority(folder / CA_FOLDER), name, role, ())


def _issue_into(folder: Path, authority: Issued, name: str, role: str, hosts: Sequence[str]) -> Path:
    issued = keys.issue(authority, name, role, hosts)
    _write(folder / name, {CA_FILE: authority.certificate, CERTIFICATE_FILE: issued.certificate, KEY_FILE: issued.key})
    return folder / name


def _read_authority(folder: Path) -> Issued:
    try:
        return Issued((folder / CA_FILE).read_bytes(), (folder / KEY_FILE).read_bytes())
    except OSError as error:
        raise RefusedError(
            f"{error.filename}: cannot be read: {error.strerror}: `edgefusion keys init` makes a CA"
        ) from error


def _write(folder: Path, files: dict[str, bytes]) -> None:
    """All of them, readable by the owner alone from the first byte on, or none."""
    folder.mkdir(parents=True, mode=0o700)
    try:
        for name, content in files.items():
            handle = os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(handle, "wb") as file:
                file.write(content)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
