# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What can go wrong with a simulated device, in PX4's words, and when it does."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Dict

from edgefusion.errors import RefusedError

COMPONENTS = ("robot", "laser", "camera")

KINDS: Dict[str, tuple[float, str]] = {
    "off": (0.0, "sends nothing any more; of robot and laser above 0: from so many bytes on into a frame"),
    "stuck": (0.0, "sends the same again and again, as if it were new"),
    "garbage": (0.01, "share of the bytes that are noise"),
    "wrong": (0.0, "sends what is well formed and not true; a camera: its brightness, 0 to 1"),
    "slow": (4.0, "only one of so many comes"),
    "delayed": (0.3, "comes so many seconds late"),
    "intermittent": (0.5, "share that does not come"),
}
"""Each with its usual value, and what that is."""

_TEXT = re.compile(r"(\w+)=(\w+)(?::([\d.]+))?(?:@([\d.]+)(?:\+([\d.]+))?)?")


@dataclass(frozen=True)
class Fault:
    """kind: of KINDS. from_s, for_s: when it begins after the start, and how long it lasts."""

    component: str
    kind: str
    value: float
    from_s: float = 0.0
    for_s: float = math.inf

    def __post_init__(self) -> None:
        if self.component not in COMPONENTS:
            raise RefusedError(f"fault: expected one of {', '.join(COMPONENTS)}, got {self.component!r}")
        if self.kind not in KINDS:
            raise RefusedError(f"fault: {self.component}: expected one of {', '.join(KINDS)}, got {self.kind!r}")
        if self.kind in ("garbage", "intermittent", "wrong") and not 0 <= self.value <= 1:
            raise RefusedError(f"fault: {self.kind}: expected a share from 0 to 1, got {self.value:g}")
        if self.kind == "slow" and self.value < 1:
            raise RefusedError(f"fault: slow: expected at least 1, got {self.value:g}")

    def holds(self, since_start_s: float) -> bool:
        """Whether it is there then."""
        return self.from_s <= since_start_s < self.from_s + self.for_s


def _takes_none(component: str, kind: str) -> bool:
    """What is cut short is a packet, what is so bright a camera's picture."""
    return kind == "stuck" or (kind == "off" and component == "camera") or (kind == "wrong" and component != "camera")


def parse_fault(text: str) -> Fault:
    """Of `laser=stuck`, `laser=garbage:0.01`, `camera=off@5`, `robot=delayed:0.3@5+2`: from 5 s on, for 2 s.

    Raises RefusedError, which names what is known.
    """
    found = _TEXT.fullmatch(text)
    if found is None:
        raise RefusedError(f"fault: expected COMPONENT=KIND[:VALUE][@FROM_S[+FOR_S]], got {text!r}")
    component, kind, *numbers = found.groups()
    try:
        value, from_s, for_s = (None if number is None else float(number) for number in numbers)
    except ValueError:
        raise RefusedError(f"fault: expected numbers, got {text!r}") from None
    if value is not None and _takes_none(component, kind):
        raise RefusedError(f"fault: {component}={kind}: expected no value, got {value:g}")
    usual = KINDS[kind][0] if kind in KINDS else 0.0
    return Fault(
        component,
        kind,
        usual if value is None else value,
        0.0 if from_s is None else from_s,
        math.inf if for_s is None else for_s,
    )
