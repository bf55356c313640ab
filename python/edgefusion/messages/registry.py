# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""All types of messages, by their names."""

from __future__ import annotations

from types import MappingProxyType, ModuleType
from typing import Iterator, Mapping

from edgefusion.messages import (
    builtin_interfaces,
    diagnostic_msgs,
    geometry_msgs,
    nav_msgs,
    sensor_msgs,
    std_msgs,
    tf2_msgs,
    vision_msgs,
    visualization_msgs,
)
from edgefusion.messages.idl import Message, ros_name

_PACKAGES = (
    builtin_interfaces, std_msgs, geometry_msgs, sensor_msgs, nav_msgs, tf2_msgs, diagnostic_msgs, visualization_msgs,
    vision_msgs,
)  # fmt: skip


def _defined_in(package: ModuleType) -> Iterator[type[Message]]:
    for value in vars(package).values():
        if isinstance(value, type) and issubclass(value, Message) and value.__module__ == package.__name__:
            yield value


MESSAGES: Mapping[str, type[Message]] = MappingProxyType(
    {ros_name(cls): cls for package in _PACKAGES for cls in _defined_in(package)}
)

for _cls in MESSAGES.values():
    # pycdr2 would do it at a type's first use, and two threads at once get in each other's way there.
    _cls.__idl__.populate()  # type: ignore[no-untyped-call]
