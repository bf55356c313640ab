# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The two codecs that are fuzzed: what their devices really say, and what a reader makes of a stream."""

from __future__ import annotations

import math
import struct
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Callable, Iterable, List, Set, Tuple

import numpy as np
import numpy.typing as npt

from edgefusion.drivers import lms2xx_telegram
from edgefusion.drivers.lms2xx_messages import (
    CENTIMETRES,
    MILLIMETRES,
    check_mode_reply,
    check_set_reply,
    parse_configuration,
    parse_status,
    parse_type,
)
from edgefusion.drivers.lms2xx_scan import SCAN, parse_scan, range_max_m, ranges_of
from edgefusion.drivers.lms2xx_telegram import TelegramReader
from edgefusion.drivers.sip import SipReader, is_packet
from edgefusion.drivers.sip_config import read_identity
from edgefusion.drivers.sip_frame import Packet, PacketFinder
from edgefusion.errors import RefusedError
from edgefusion.sim import lms_scanner_telegrams as telegrams
from edgefusion.sim import sip_robot_packets as packets
from edgefusion.sim.sip_robot_character import H8, SH

Rng = np.random.Generator
Place = Tuple[int, bytes]
"""Where a packet ends in its stream, and what it says."""


@dataclass(frozen=True)
class Reading:
    """What a reader found, and the processor's time that it took for all of it."""

    found: Set[Place]
    seconds: float


@dataclass(frozen=True)
class Codec:
    """say: so many packets of a device. body: what a packet says. soup: bytes that mean something to the reader.

    byte_s: what a byte takes on the fastest line: a reader that takes longer falls behind.
    """

    name: str
    say: Callable[[Rng, int], List[bytes]]
    body: Callable[[bytes], bytes]
    read: Callable[[Iterable[bytes]], Reading]
    soup: bytes
    byte_s: float


def _say_sip(rng: Rng, count: int) -> List[bytes]:
    """Reports as the simulated robot's, with up to eight sonars; now and then its names and parameters."""
    said = []
    for number in range(count):
        if number % 50 == 49:
            character = (H8, SH)[int(rng.integers(2))]
            said.append((packets.identity, packets.parameters)[int(rng.integers(2))](character))
            continue
        x, y = (int(each) for each in rng.integers(0, 0x8000, 2))
        heading = int(rng.integers(-2048, 2048))
        left, right = (int(each) for each in rng.integers(-1000, 1001, 2))
        numbers = rng.permutation(16)[: rng.integers(9)]
        fired = [(int(each), int(rng.integers(100, 5001))) for each in numbers]
        said.append(
            packets.status(
                (x, y, heading),
                (left, right),
                right - left,
                125,
                (False, False),
                (0, 0),
                True,
                False,
                True,
                fired,
                (0, 0),
            )
        )
    return said


def _read_sip(pieces: Iterable[bytes]) -> Reading:
    """A CONFIGpac that is believed in spite of its checksum is not counted.

    Raises AssertionError where the reader's messages are not the packets that were found.
    """
    reader, finder = SipReader(), PacketFinder(is_packet)
    messages, seconds = 0, 0.0
    found: List[Packet] = []
    for piece in pieces:
        start = time.process_time()
        messages += len(reader.feed(piece))
        seconds += time.process_time() - start
        found += finder.feed(piece)
    start = time.process_time()
    messages += len(reader.give_up())
    seconds += time.process_time() - start
    found += finder.give_up()
    assert messages + reader.unknown_packets == len(found)
    for packet in found:
        with suppress(RefusedError):
            read_identity(packet.body)
    return Reading({(packet.end, packet.body) for packet in found if packet.checksum_holds}, seconds)


def _say_lms(rng: Rng, count: int) -> List[bytes]:
    """Scans of all sizes as the simulated laser's; now and then an answer."""
    said = []
    for number in range(count):
        mode = int(rng.integers(7))
        if number % 20 == 19:
            answer = (b"\xa0\x00", b"\xba" + telegrams.MODEL, b"\xf4" + bytes(telegrams.usual_block()))
            payload = answer[int(rng.integers(len(answer)))]
        else:
            beams = int(rng.choice([101, 181, 201, 361, 401]))
            ranges_m = rng.uniform(0.1, 8.0, beams).astype(np.float32)
            ranges_m[rng.random(beams) < 0.05] = math.inf
            unit = int(rng.choice([CENTIMETRES, MILLIMETRES]))
            payload = telegrams.scan(ranges_m, telegrams.ScanHeader(unit, False, 0), mode)
        said.append(lms2xx_telegram.encode(payload + b"\x10", 0x80))
    return said


def _read_lms(pieces: Iterable[bytes]) -> Reading:
    reader, received, seconds = TelegramReader(), [], 0.0
    for piece in pieces:
        start = time.process_time()
        received += reader.feed(piece)
        seconds += time.process_time() - start
    start = time.process_time()
    received += reader.silence()
    seconds += time.process_time() - start
    telegrams_only = [item for item in received if item.handshake is None]
    for item in telegrams_only:
        _understand(item.payload)
    return Reading({(item.end, item.payload) for item in telegrams_only if _is_believed(item.payload)}, seconds)


def _is_believed(payload: bytes) -> bool:
    if payload[0] != SCAN:
        return True
    with suppress(RefusedError):
        parse_scan(payload)
        return True
    return False


def _understand(payload: bytes) -> None:
    """As any answer that a driver may take it for: nothing but a refusal may come of it."""
    parsers: Tuple[Callable[[], object], ...] = (
        lambda: parse_status(payload).variant.turns,
        lambda: parse_configuration(payload),
        lambda: parse_type(payload),
        lambda: check_mode_reply(payload),
        lambda: check_set_reply(payload, "answer"),
        lambda: [_in_metres(payload, mode) for mode in range(7)],
    )
    for parse in parsers:
        with suppress(RefusedError):
            parse()


def _in_metres(payload: bytes, mode: int) -> Tuple[npt.NDArray[np.float32], float]:
    raw = parse_scan(payload)
    return ranges_of(raw, mode), range_max_m(raw, mode)


SIP = Codec("SIP", _say_sip, lambda packet: packet[3:-2], _read_sip, b"\xfa\xfb\x03\x06\x30\x32\x20\x00", 10 / 115_200)
LMS = Codec(
    "LMS2xx",
    _say_lms,
    lambda packet: packet[4:-2],
    _read_lms,
    struct.pack("<8B", 2, 0x80, 1, 3, 0xB0, 6, 0, 0x15),
    10 / 500_000,
)
