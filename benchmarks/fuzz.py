# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The readers of both wire protocols on what no device sends: random bytes, mutated and cut packets, noisy real ones.

Aims: no exception; at 1 % of wrong bytes at least 99.9 % of the intact packets kept; no stream takes longer to read
than it takes to arrive on its fastest line. A stream that raises is kept beside the table. Exits 1 where one is missed.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Sequence

import numpy as np
from benchmarks.fuzz_codecs import LMS, SIP
from benchmarks.fuzz_streams import KINDS, Sent, noisy, pieces
from benchmarks.fuzz_tally import HEADER, Tally
from benchmarks.run import markdown
from tqdm import tqdm

from edgefusion.tools.arguments import seed_number

EXAMPLES = """examples:
  python -m benchmarks.fuzz
  python -m benchmarks.fuzz --minutes 0.5 --seed 7 --out out/fuzz"""

RATES = (0.001, 0.01, 0.03)
_PACKETS = 400


class Fuzzer:
    """Feeds stream after stream, each kind in turn; the same seed gives the same ones."""

    def __init__(self, seed: int, out: Path) -> None:
        self._rng, self._out = np.random.default_rng(seed), out
        self.tallies = [
            tally
            for codec in (SIP, LMS)
            for tally in (
                *(Tally(codec, f"real, {100 * rate:g} % of bytes wrong", rate) for rate in RATES),
                *(Tally(codec, kind) for kind in KINDS),
            )
        ]

    def round(self) -> None:
        """One stream of each kind for each codec."""
        for tally in self.tallies:
            self._feed(tally)

    def _feed(self, tally: Tally) -> None:
        codec, rng = tally.codec, self._rng
        sent = (
            Sent(KINDS[tally.kind](codec, rng), set(), 0)
            if tally.error_rate is None
            else noisy(codec, rng, _PACKETS, tally.error_rate)
        )
        try:
            reading = codec.read(pieces(sent.stream, rng))
        except Exception as error:  # whatever it is, it is what is looked for
            tally.exceptions += 1
            kind = tally.kind.replace(" ", "_")
            name = f"{codec.name}-{kind}-{type(error).__name__}-{tally.exceptions}.bin"
            (self._out / name).write_bytes(sent.stream)
            return
        tally.add(sent, reading)


def main(argv: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(argv)
    args.out.mkdir(parents=True, exist_ok=True)
    fuzzer = Fuzzer(args.seed, args.out)
    end = time.monotonic() + 60 * args.minutes
    with tqdm(unit="round", file=sys.stderr, disable=None) as bar:
        fuzzer.round()
        while time.monotonic() < end:
            fuzzer.round()
            bar.update()
            bar.set_postfix_str(f"{max(0.0, end - time.monotonic()):.0f} s left", refresh=False)
    table = markdown(HEADER, [tally.cells() for tally in fuzzer.tallies])
    path = args.out / "table.md"
    path.write_text(table + "\n")
    print(table)
    print(f"written to {path}", file=sys.stderr)
    return int(any(tally.missed for tally in fuzzer.tallies))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fuzz",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--minutes", type=_minutes, default=10.0, metavar="M", help="how long (default: 10)")
    parser.add_argument("--seed", type=seed_number, default=0, metavar="N", help="of the streams (default: 0)")
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"), metavar="DIR", help="default: out/fuzz")
    return parser


def _minutes(text: str) -> float:
    minutes = float(text)
    if not 0 <= minutes <= 1440:
        raise argparse.ArgumentTypeError(f"expected minutes from 0 to 1440, got {text}")
    return minutes


if __name__ == "__main__":
    sys.exit(main())
