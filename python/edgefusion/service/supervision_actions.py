# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What a supervision wants done."""

from __future__ import annotations

from typing import Any, Mapping, NamedTuple, Union

from edgefusion.service.child_spec import ChildSpec


class Start(NamedTuple):
    """To be answered by started() or not_started(). stopped: why an operator has stopped the one before it."""

    spec: ChildSpec
    stopped: str = ""


class Send(NamedTuple):
    """A signal to a child."""

    name: str
    number: int


class StopRobot(NamedTuple):
    """To be answered by robot_stopped(). status: which port it is at, if the child ever said so. by_ns: at the latest,
    None: no hurry but for its own sake."""

    name: str
    status: Mapping[str, Any]
    by_ns: int | None


Action = Union[Start, Send, StopRobot]
