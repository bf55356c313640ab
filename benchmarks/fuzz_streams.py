# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Streams that no device sends: noise on what it does send, and what looks like it."""

from __future__ import annotations

from typing import Callable, Dict, List, NamedTuple, Set

import numpy as np
from benchmarks.fuzz_codecs import Codec, Place, Rng

_BYTES = 8192


class Sent(NamedTuple):
    """A stream, the packets in it that are intact, and how many it had."""

    stream: bytes
    intact: Set[Place]
    packets: int


def noisy(codec: Codec, rng: Rng, packets: int, error_rate: float) -> Sent:
    """The stream of so many packets with that share of its bytes wrong."""
    said = codec.say(rng, packets)
    stream = np.frombuffer(b"".join(said), np.uint8).copy()
    hit = rng.random(len(stream)) < error_rate
    stream[hit] ^= rng.integers(1, 256, int(hit.sum()), dtype=np.uint8)
    intact, begin = set(), 0
    for packet in said:
        end = begin + len(packet)
        if not hit[begin:end].any():
            intact.add((end, codec.body(packet)))
        begin = end
    return Sent(stream.tobytes(), intact, len(said))


def _random(codec: Codec, rng: Rng) -> bytes:
    return rng.bytes(_BYTES)


def _soup(codec: Codec, rng: Rng) -> bytes:
    """Of bytes that begin packets, count and end them."""
    return bytes(rng.choice(np.frombuffer(codec.soup, np.uint8), _BYTES))


def _repeated(codec: Codec, rng: Rng) -> bytes:
    """False headers as close to each other as they can be, each with a length of its own."""
    pattern = codec.soup[:2] + rng.bytes(int(rng.integers(1, 4)))
    return (pattern * _BYTES)[:_BYTES]


def _truncated(codec: Codec, rng: Rng) -> bytes:
    """Each packet ends somewhere, as where a cable was pulled."""
    return b"".join(packet[: rng.integers(len(packet) + 1)] for packet in codec.say(rng, 200))[:_BYTES]


def _mutated(codec: Codec, rng: Rng) -> bytes:
    """Real packets in which pieces were cut out, doubled, swapped and set to extremes."""
    stream = bytearray(b"".join(codec.say(rng, 200))[:_BYTES])
    for _ in range(int(rng.integers(1, 60))):
        at, size, to = int(rng.integers(len(stream))), int(rng.integers(1, 40)), int(rng.integers(len(stream)))
        kind = rng.integers(4)
        if kind == 0 and len(stream) > 2 * size:
            del stream[at : at + size]
        elif kind == 1:
            stream[to:to] = stream[at : at + size]
        elif kind == 2:
            stream[at] = int(rng.choice([0x00, 0x01, 0x7F, 0x80, 0xFF]))
        else:
            stream[at] ^= 1 << int(rng.integers(8))
    return bytes(stream)


KINDS: Dict[str, Callable[[Codec, Rng], bytes]] = {
    "random bytes": _random,
    "bytes of headers": _soup,
    "one header again and again": _repeated,
    "truncated packets": _truncated,
    "mutated packets": _mutated,
}


def pieces(stream: bytes, rng: Rng) -> List[bytes]:
    """A stream as reads may cut it: byte by byte, in the pieces of a port, or all at once."""
    most = int(rng.choice([1, 7, 100, 1000, len(stream) + 1]))
    cut, begin = [], 0
    while begin < len(stream):
        end = begin + int(rng.integers(1, most + 1))
        cut.append(stream[begin:end])
        begin = end
    return cut
