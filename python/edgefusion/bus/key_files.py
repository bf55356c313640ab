# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A folder with what one machine needs to prove who it is: the CA's certificate, its own, and its own's key."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Mapping

from edgefusion.errors import RefusedError

ROLES = ("robot", "operator", "viewer")
"""robot: the router, and the processes that publish. The role is what a certificate is issued to (its common name)."""

CA_FILE, CERTIFICATE_FILE, KEY_FILE = "ca.pem", "cert.pem", "key.pem"
READ_BY_OTHERS = 0o007


@dataclass(frozen=True)
class KeyFiles:
    """Paths of PEM files."""

    ca: Path
    certificate: Path
    key: Path


def find_keys(folder: Path) -> KeyFiles:
    """The keys in a folder. Raises RefusedError where one is missing, or where others can read the secret one."""
    files = KeyFiles(folder / CA_FILE, folder / CERTIFICATE_FILE, folder / KEY_FILE)
    for path in (files.ca, files.certificate, files.key):
        if not os.access(path, os.R_OK):
            raise RefusedError(f"keys: expected a readable file {path}: `edgefusion keys init` makes a folder of them")
    if files.key.stat().st_mode & READ_BY_OTHERS:
        raise RefusedError(f"keys: expected a key that only its owner can read, got {files.key}: chmod 600 it")
    return files


def usual_folder(environment: Mapping[str, str], home: Path) -> Path:
    """Where a laptop's keys are looked for: $EDGEFUSION_KEYS, else .config/edgefusion/keys below home."""
    named = environment.get("EDGEFUSION_KEYS")
    return Path(named) if named else home / ".config" / "edgefusion" / "keys"
