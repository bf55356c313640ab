# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A laser's telegrams over a line whose bytes are noise now and then: what of them may be driven by."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Deque, Tuple

import numpy as np

from edgefusion.drivers.lms2xx_judgement import LineQuality
from edgefusion.drivers.lms2xx_scan import SCAN
from edgefusion.drivers.lms2xx_telegram import FRAME_BYTES, TelegramReader, encode

_BEAMS, _MILLIMETRES, _NORMAL, _WAITING = 361, 0x4000, b"\x10", 40


@dataclass
class NoisyStream:
    """intact: telegrams of which no byte was noise; kept: those of them that were read; used: those that were read from
    a line that was good enough then. false: telegrams that were read and never sent; driven_by: the same, used."""

    intact: int = 0
    kept: int = 0
    used: int = 0
    false: int = 0
    driven_by: int = 0

    def __add__(self, other: NoisyStream) -> NoisyStream:
        pairs = zip(vars(self).values(), vars(other).values())
        return NoisyStream(*(mine + its for mine, its in pairs))


def noisy_stream(rng: np.random.Generator, telegrams: int, error: float) -> NoisyStream:
    """error: the share of the bytes that are another."""
    reader, line, run = TelegramReader(), LineQuality(0), NoisyStream()
    sent: Deque[Tuple[bytes, bool]] = deque(maxlen=_WAITING)
    for _ in range(telegrams):
        payload = _scan(rng)
        data = np.frombuffer(encode(payload, 0x80), np.uint8).copy()
        hit = rng.random(len(data)) < error
        data[hit] ^= rng.integers(1, 256, int(hit.sum()), dtype=np.uint8)
        sent.append((payload, not hit.any()))
        run.intact += sent[-1][1]
        for item in reader.feed(data.tobytes()):
            if item.handshake is None and item.payload[0] == SCAN:
                line.telegram(len(item.payload) + FRAME_BYTES, reader.discarded_bytes)
                _count(run, item.payload, sent, not line.fault)
    return run


def _scan(rng: np.random.Generator) -> bytes:
    ranges = rng.integers(50, 8000, _BEAMS).astype("<u2").tobytes()
    return bytes([SCAN]) + (_BEAMS | _MILLIMETRES).to_bytes(2, "little") + ranges + _NORMAL


def _count(run: NoisyStream, payload: bytes, sent: Deque[Tuple[bytes, bool]], good: bool) -> None:
    was_sent = [intact for said, intact in sent if said == payload]
    if not was_sent:
        run.false += 1
        run.driven_by += good
    elif was_sent[0]:
        run.kept += 1
        run.used += good
