# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Which commands count: neither old, repeated, too large nor too many. Pure: the time is passed in.

A command's age counts from its receipt by the clock of this computer, whatever clock its sender has.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from dataclasses import dataclass
from enum import Enum
from typing import Counter as CounterOf
from typing import Optional

from edgefusion.bus.rate_limit import RateLimit
from edgefusion.bus.tags import CommandTag, read_tag
from edgefusion.config.bus import BusConfig
from edgefusion.errors import RefusedError

MOST_SESSIONS = 1024
"""So many senders' numbers are remembered, those that were heard last."""


class Refusal(str, Enum):
    """Why a command does not count."""

    OVERSIZED = "oversized"
    UNTAGGED = "without session and number"
    BAD_TAG = "a tag that is none"
    REPLAYED = "replayed"
    EXPIRED = "expired"
    TOO_MANY = "too many"
    MALFORMED = "malformed"


@dataclass(frozen=True)
class CommandLimits:
    """Of commands of one kind. burst: so many may come at once; allow_plain: also without a tag."""

    max_bytes: int
    max_hz: float
    burst: int = 10
    allow_plain: bool = False
    plain_ttl_ms: int = 200


def limits_of(config: BusConfig) -> CommandLimits:
    """What a robot with this configuration takes."""
    return CommandLimits(
        config.max_command_bytes,
        config.max_command_hz,
        allow_plain=config.allow_plain_ros,
        plain_ttl_ms=round(config.cmd_vel_timeout_s * 1e3),
    )


class Freshness:
    """Judges the commands of one kind; counts: of those that were refused, by reason."""

    def __init__(self, limits: CommandLimits) -> None:
        self._limits = limits
        self._rate = RateLimit(limits.max_hz, limits.burst)
        self._last_seq: OrderedDict[str, int] = OrderedDict()
        self.counts: CounterOf[Refusal] = Counter()
        self.accepted = 0

    def judge(self, now_ns: int, received_ns: int, size: int, attachment: Optional[bytes]) -> Optional[Refusal]:
        """None for a command that counts. size: of its payload in bytes."""
        refusal = self._refusal(now_ns, received_ns, size, attachment)
        if refusal is None:
            self.accepted += 1
        else:
            self.counts[refusal] += 1
        return refusal

    def malformed(self) -> None:
        """The command that was accepted last turned out to be none when it was decoded; it takes nobody's place."""
        self.accepted -= 1
        self._rate.give_back()
        self.counts[Refusal.MALFORMED] += 1

    def _refusal(self, now_ns: int, received_ns: int, size: int, attachment: Optional[bytes]) -> Optional[Refusal]:
        if size > self._limits.max_bytes:
            return Refusal.OVERSIZED
        ttl_ms = self._limits.plain_ttl_ms
        if attachment is None:
            if not self._limits.allow_plain:
                return Refusal.UNTAGGED
        else:
            try:
                tag = read_tag(CommandTag, attachment)
            except RefusedError:
                return Refusal.BAD_TAG
            if not self._rises(tag):
                return Refusal.REPLAYED
            ttl_ms = tag.ttl_ms
        if now_ns - received_ns > ttl_ms * 1_000_000:
            return Refusal.EXPIRED
        return None if self._rate.allows(now_ns) else Refusal.TOO_MANY

    def _rises(self, tag: CommandTag) -> bool:
        last_seq = self._last_seq.pop(tag.session, -1)
        self._last_seq[tag.session] = max(tag.seq, last_seq)
        if len(self._last_seq) > MOST_SESSIONS:
            self._last_seq.popitem(last=False)
        return tag.seq > last_seq
