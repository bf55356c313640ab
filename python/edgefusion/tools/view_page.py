# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The address of Rerun's page."""

from __future__ import annotations

from urllib.parse import quote


def page_of(address: str, web_port: int, host: str = "localhost") -> str:
    """What to open in a browser for the data at an address. host: this computer, as the browser's knows it."""
    return f"http://{host}:{web_port}/?url={quote(address, safe='')}"
