# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Names and distances of the objects in front of a robot, from a 2D laser and a camera."""

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from edgefusion.bus.client import connect as connect

__version__ = version("edgefusion")


def __getattr__(name: str) -> Any:
    """`edgefusion.connect`, which loads Zenoh."""
    if name == "connect":
        from edgefusion.bus.client import connect

        return connect
    raise AttributeError(f"module 'edgefusion' has no attribute {name!r}")
