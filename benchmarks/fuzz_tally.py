# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What became of the streams of one kind, and whether that is as it should be."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.fuzz_codecs import Codec, Reading
from benchmarks.fuzz_streams import Sent

AIMED_RATE, KEPT = 0.01, 0.999
"""At this share of wrong bytes, so many of the intact packets are to be kept."""

HEADER = ("codec", "stream", "kB", "packets", "intact", "kept", "false", "exceptions", "slowest ms/kB", "aims")


@dataclass
class Tally:
    """error_rate: of noise on real packets, None for the streams that no device sends.

    size: in bytes. false_accepts: packets that were found and are none of the intact ones. slowest_s: a byte of the
    slowest stream.
    """

    codec: Codec
    kind: str
    error_rate: float | None = None
    size: int = 0
    packets: int = 0
    intact: int = 0
    kept: int = 0
    false_accepts: int = 0
    exceptions: int = 0
    slowest_s: float = 0.0

    def add(self, sent: Sent, reading: Reading) -> None:
        """A stream that was read to its end."""
        self.size += len(sent.stream)
        self.packets += sent.packets
        self.intact += len(sent.intact)
        self.kept += len(sent.intact & reading.found)
        self.false_accepts += len(reading.found - sent.intact) if self.error_rate is not None else 0
        self.slowest_s = max(self.slowest_s, reading.seconds / max(1, len(sent.stream)))

    @property
    def missed(self) -> list[str]:
        """The aims that were missed, each in a word."""
        kept = self.kept >= KEPT * self.intact or self.error_rate != AIMED_RATE
        checks = {"exceptions": self.exceptions == 0, "kept": kept, "speed": self.slowest_s <= self.codec.byte_s}
        return [name for name, holds in checks.items() if not holds]

    def cells(self) -> list[str]:
        """As a row of the table."""
        noise = self.error_rate is not None
        return [
            self.codec.name,
            self.kind,
            f"{self.size / 1e3:.0f}",
            str(self.packets) if noise else "-",
            str(self.intact) if noise else "-",
            f"{100 * self.kept / self.intact:.3f} %" if self.intact else "-",
            str(self.false_accepts) if noise else "-",
            str(self.exceptions),
            f"{1e6 * self.slowest_s:.2f} of {1e6 * self.codec.byte_s:.0f}",
            f"missed: {', '.join(self.missed)}" if self.missed else "met",
        ]
