# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where a bus listens or is found: tcp/HOST:PORT or tls/HOST:PORT."""

from __future__ import annotations

import ipaddress
import re
from dataclasses import dataclass

from edgefusion.errors import RefusedError

_FORM = re.compile(r"(tcp|tls)/(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9_.-]+):([0-9]{1,5})")


@dataclass(frozen=True)
class Endpoint:
    """host: a name, an IPv4 address, or an IPv6 address in brackets."""

    protocol: str
    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.protocol}/{self.host}:{self.port}"

    @property
    def is_loopback(self) -> bool:
        """Whether only programs on the same computer reach it; a name other than localhost is none that is known to."""
        try:
            return self.host == "localhost" or ipaddress.ip_address(self.host.strip("[]")).is_loopback
        except ValueError:
            return False


def parse_endpoint(name: str, text: str) -> Endpoint:
    """name: of the setting. Raises RefusedError for what is no endpoint."""
    match = _FORM.fullmatch(text)
    if match is None or not 0 < int(match.group(3)) < 65536:
        raise RefusedError(f"{name}: expected tcp/HOST:PORT or tls/HOST:PORT, got {text!r}")
    return Endpoint(match.group(1), match.group(2), int(match.group(3)))
