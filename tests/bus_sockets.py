# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""On which addresses this process listens, as the kernel says."""

from __future__ import annotations

import ipaddress
import sys
from contextlib import suppress
from pathlib import Path
from typing import Set, Tuple

Listener = Tuple[str, str, int]
"""Protocol, address and port; every socket of UDP listens."""

_TCP_LISTEN = "0A"


def listening() -> Set[Listener]:
    own = _own_sockets()
    found = set()
    for table in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/self/net/{table}").read_text(encoding="ascii").splitlines()[1:]:
            fields = line.split()
            if fields[9] in own and (table.startswith("udp") or fields[3] == _TCP_LISTEN):
                address, port = fields[1].split(":")
                found.add((table, _address(address), int(port, 16)))
    return found


def _own_sockets() -> Set[str]:
    inodes = set()
    for link in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # closed in between
            target = str(link.readlink() if sys.version_info >= (3, 9) else link.resolve().name)
            if target.startswith("socket:["):
                inodes.add(target[len("socket:[") : -1])
    return inodes


def _address(text: str) -> str:
    words = [bytes.fromhex(text[i : i + 8])[::-1] for i in range(0, len(text), 8)]
    return str(ipaddress.ip_address(b"".join(words)))
