# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which sockets a process has open to the outside, as the kernel says."""

from __future__ import annotations

import ipaddress
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, List

from edgefusion.tools.doctor_holders import PROC

_TABLES = ("tcp", "tcp6", "udp", "udp6")
_LISTENS = "0A"
_WORD = 4
_IPV4_BYTES = 4


@dataclass(frozen=True)
class Socket:
    """protocol: tcp or udp. address: an IPv4 or IPv6 address, and a port. listens: of tcp, whether others connect."""

    protocol: str
    address: str
    port: int
    listens: bool

    @property
    def is_loopback(self) -> bool:
        """Whether only this computer reaches it."""
        return ipaddress.ip_address(self.address).is_loopback


def own_sockets(proc: Path = PROC) -> List[Socket]:
    """All of TCP and UDP that this process has open."""
    return sockets_of(proc / "self")


def sockets_of(process: Path) -> List[Socket]:
    """All of TCP and UDP that a process of the same user has open. process: its folder in /proc."""
    inodes = set(_inodes(process))
    return [_socket(table, words) for table in _TABLES for words in _rows(process, table) if words[9] in inodes]


def _inodes(process: Path) -> Iterator[str]:
    for each in (process / "fd").iterdir():
        try:
            target = os.readlink(each)
        except OSError:  # closed meanwhile, as the folder's own
            continue
        if target.startswith("socket:["):
            yield target[len("socket:[") : -1]


def _rows(process: Path, table: str) -> List[List[str]]:
    try:
        lines = (process / "net" / table).read_text().splitlines()
    except OSError:  # a kernel without IPv6
        return []
    return [line.split() for line in lines[1:]]


def _socket(table: str, words: List[str]) -> Socket:
    address, _, port = words[1].partition(":")
    protocol = table[: len("tcp")]
    listens = protocol == "tcp" and words[3] == _LISTENS
    return Socket(protocol, _address(bytes.fromhex(address)), int(port, 16), listens)


def _address(raw: bytes) -> str:
    """The kernel prints it in words of the processor's byte order, which is little-endian wherever this runs."""
    packed = b"".join(raw[begin : begin + _WORD][::-1] for begin in range(0, len(raw), _WORD))
    kind = ipaddress.IPv4Address if len(packed) == _IPV4_BYTES else ipaddress.IPv6Address
    return str(kind(packed))
