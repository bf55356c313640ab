# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The fuzzer would tell: a reader that raises, loses packets, believes noise or is slow misses its aims."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import fuzz
from benchmarks.fuzz_codecs import LMS, SIP, Codec, Reading
from benchmarks.fuzz_streams import KINDS, Sent, noisy, pieces
from benchmarks.fuzz_tally import Tally

CODECS = pytest.mark.parametrize("codec", [SIP, LMS], ids=lambda codec: codec.name)


@CODECS
def test_without_errors_all_packets_are_found_in_any_pieces(codec: Codec) -> None:
    rng = np.random.default_rng(1)
    sent = noisy(codec, rng, 60, 0.0)
    assert len(sent.intact) == sent.packets == 60
    assert codec.read(pieces(sent.stream, rng)).found == sent.intact


@CODECS
@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_stream_and_its_pieces_are_all_of_it(codec: Codec, kind: str) -> None:
    first, again = (KINDS[kind](codec, np.random.default_rng(3)) for _ in range(2))
    assert first == again and len(first) > 1000
    assert b"".join(pieces(first, np.random.default_rng(4))) == first


def test_a_tally_names_each_aim_that_is_missed() -> None:
    place = (10, b"a"), (20, b"b")
    tally = Tally(SIP, "real", 0.01)
    tally.add(Sent(bytes(20), set(place), 2), Reading(set(place), 0.0))
    assert tally.missed == []
    tally.add(Sent(bytes(20), set(place), 2), Reading({place[0], (15, b"c")}, 1.0))
    assert (tally.missed, tally.kept, tally.false_accepts) == (["kept", "speed"], 3, 1)


def test_a_stream_that_raises_is_kept_and_the_exit_code_is_1(tmp_path: Path, monkeypatch, capsys) -> None:
    def read(parts: list[bytes]) -> Reading:
        raise ValueError(len(parts))

    monkeypatch.setattr(fuzz, "LMS", replace(LMS, read=read))
    assert fuzz.main(["--minutes", "0", "--out", str(tmp_path)]) == 1
    assert "missed: exceptions" in capsys.readouterr().out
    assert len(list(tmp_path.glob("LMS2xx-*-ValueError-1.bin"))) == 3 + len(KINDS)


def test_a_quick_run_meets_its_aims_and_writes_them_down(tmp_path: Path, capsys) -> None:
    assert fuzz.main(["--minutes", "0", "--out", str(tmp_path)]) == 0
    table = (tmp_path / "table.md").read_text()
    assert table == capsys.readouterr().out and table.count("| met") == 2 * (3 + len(KINDS))
