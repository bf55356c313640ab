# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Recorded connections of a host (C) and a robot (R), and SIPs made up for tests."""

from __future__ import annotations

import struct
from pathlib import Path

from edgefusion.drivers.sip_frame import frame

REAL_CONFIG_START = bytes.fromhex(
    "fafb8920" + b"Pioneer\0p3dx-sh\0GJC_3156\0".hex() + "006801e8032c01d007f401" + b"FAPESP_3156\0".hex() + "640000"
)


def read_trace(path: Path, sender: str) -> list[tuple[bytes, bool]]:
    """The packets that one side sent, and whether their checksums hold as the recorder saw it."""
    lines = [line.split("ck=", 1) for line in path.read_text().splitlines() if f" {sender}>" in line and "ck=" in line]
    return [(bytes.fromhex(rest[3:].strip()), rest.startswith("ok")) for _, rest in lines]


def sip_body(x=0, y=0, heading=0, left=0, right=0, rear=0, front=0, flags=1, sonars=(), tail=b"", kind=0x32) -> bytes:
    fixed = struct.pack("<BHHhhhBBBhHBB", kind, x, y, heading, left, right, 120, rear, front, 0, flags, 0, len(sonars))
    return fixed + b"".join(struct.pack("<BH", *each) for each in sonars) + tail


def sip(**values) -> bytes:
    return frame(sip_body(**values))
