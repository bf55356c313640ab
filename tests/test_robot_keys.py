# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The keys that drive a robot, as a terminal hands them over."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.tools.robot_keys import HELD_NS, Keys
from edgefusion.types import Twist2D

MS = 1_000_000


@pytest.mark.parametrize(
    ("typed", "way"),
    [
        *((b"w", (1, 0)), (b"S", (-1, 0)), (b"a", (0, 1)), (b"D", (0, -1))),
        *((b"\x1b[A", (1, 0)), (b"\x1b[B", (-1, 0)), (b"\x1bOD", (0, 1)), (b"\x1b[C", (0, -1))),
        *((b"w ", (0, 0)), (b"wx", (0, 0)), (b"wa", (0, 1)), (b"w\x1b ", (0, 0)), (b"\x1bw", (1, 0))),
        *((b"w\x1b[1;5D", (0, 0)), (b"w\x1b[3~", (0, 0)), (b"w\x1b[" + b"1" * 20, (0, 0))),
    ],
)
def test_each_key_has_its_way_and_any_other_stops(typed: bytes, way: tuple[int, int]) -> None:
    keys = Keys(0.2, 0.5)
    keys.press(typed, 0)
    assert keys.twist(0) == Twist2D(0.2 * way[0], 0.5 * way[1])


def test_a_key_that_is_not_repeated_was_let_go() -> None:
    keys = Keys(0.2, 0.5)
    keys.press(b"w", 0)
    assert keys.twist(HELD_NS - 1) == Twist2D(0.2)
    keys.press(b"w", HELD_NS - 1)
    assert keys.twist(2 * HELD_NS - 2) == Twist2D(0.2)
    assert keys.twist(2 * HELD_NS) == Twist2D()
    assert keys.twist(2 * HELD_NS + 1) == Twist2D()


@given(pieces=st.lists(st.binary(max_size=4)))
def test_whatever_is_typed_the_speed_is_within_what_was_asked_for(pieces: list[bytes]) -> None:
    keys = Keys(0.2, 0.5)
    for piece in pieces:
        keys.press(piece, 0)
        assert abs(keys.twist(0).v_mps) in (0, 0.2)
        assert abs(keys.twist(0).w_radps) in (0, 0.5)


def test_an_arrow_may_come_in_pieces() -> None:
    keys = Keys(0.2, 0.5)
    for byte in b"\x1b[A":
        keys.press(bytes([byte]), 0)
    assert keys.twist(0) == Twist2D(0.2)


def test_an_escape_by_itself_takes_no_other_key_away() -> None:
    keys = Keys(0.2, 0.5)
    keys.press(b"\x1b", 0)
    keys.press(b"q", 0)
    assert keys.quit
