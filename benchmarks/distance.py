# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How far off the distance of an object is: edgefusion's corrected nearest range beside the paper's min(r).

Flat faces, turned boxes and cylinders at random places 0.5 to 5 m away, seen by beams of 0.5 degree with a noise of
10 mm, of which 1 % are dropped; truth is the nearest point of the surface. Mixed: a beam at half of the edges also hits
what is behind, and reads up to 0.25 m too far.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterator, Sequence

import numpy as np
import numpy.typing as npt
from benchmarks.run import markdown, write_results

from edgefusion._core import nearest_range

EXAMPLES = """examples:
  python -m benchmarks.distance
  python -m benchmarks.distance --objects 500 --seed 1"""

Floats = npt.NDArray[np.float64]
Estimator = Callable[[Floats], "tuple[float, float]"]
"""The ranges of an object's beams [m] to its distance and the sigma of that [m]."""

SIGMA_M, DROPPED, MIXED_M = 0.01, 0.01, 0.25
MIN_BEAMS = 5
ANGLES = np.radians(np.arange(-90, 90.25, 0.5))
BEAMS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)


@dataclass(frozen=True)
class Seen:
    """One object without noise: the ranges [m] of all beams, inf where they miss it, and its true distance."""

    ranges_m: Floats
    nearest_m: float


def corrected(ranges_m: Floats) -> tuple[float, float]:
    """edgefusion's."""
    range_m, sigma_m, _ = nearest_range(ranges_m, SIGMA_M)
    return range_m, sigma_m


def minimum(ranges_m: Floats) -> tuple[float, float]:
    """The paper's, with the noise of one beam as its sigma."""
    return float(ranges_m.min()), SIGMA_M


ESTIMATORS: dict[str, Estimator] = {"edgefusion": corrected, "the paper's min(r)": minimum}


def face(random: np.random.Generator) -> Seen:
    """A flat face, turned by up to 50 degrees."""
    distance_m, bearing, width_m = place(random)
    centre = distance_m * direction(bearing)
    along = direction(bearing + np.pi / 2 + random.uniform(-0.9, 0.9))
    return polygon(np.stack([centre - along * width_m / 2, centre + along * width_m / 2]))


def box(random: np.random.Generator) -> Seen:
    """A box of any depth, turned by any angle."""
    distance_m, bearing, width_m = place(random)
    depth_m = random.uniform(0.15, 0.6)
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (width_m / 2, depth_m / 2)
    x, y = direction(random.uniform(0, np.pi / 2))
    return polygon(corners @ np.array([[x, y], [-y, x]]) + (distance_m + depth_m) * direction(bearing), closed=True)


def cylinder(random: np.random.Generator) -> Seen:
    """A cylinder, from a post to a drum."""
    distance_m, bearing, width_m = place(random)
    radius_m = width_m / 2 if random.random() < 0.5 else random.uniform(0.05, 0.2)
    centre = (distance_m + radius_m) * direction(bearing)
    along = BEAMS @ centre
    under_root = along**2 - centre @ centre + radius_m**2
    ranges_m = np.where(under_root >= 0, along - np.sqrt(np.maximum(under_root, 0)), np.inf)
    return Seen(ranges_m, distance_m)


def place(random: np.random.Generator) -> tuple[float, float, float]:
    """Distance [m], bearing and width [m] of an object."""
    return random.uniform(0.5, 5), random.uniform(-0.5, 0.5), random.uniform(0.15, 0.8)


def direction(angle: float) -> Floats:
    return np.array([np.cos(angle), np.sin(angle)])


def polygon(corners: Floats, closed: bool = False) -> Seen:
    """What the beams see of the edges between corners [n, 2]."""
    ends = np.roll(corners, -1, axis=0)
    edges = list(zip(corners, ends - corners))[: None if closed else -1]
    ranges_m = np.min([hit(start, edge) for start, edge in edges], axis=0)
    return Seen(ranges_m, min(nearest_point(start, edge) for start, edge in edges))


def hit(start: Floats, edge: Floats) -> Floats:
    """Range of every beam to one edge; inf where it misses."""
    across = BEAMS[:, 0] * edge[1] - BEAMS[:, 1] * edge[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        range_m = (start[0] * edge[1] - start[1] * edge[0]) / across
        share = (start[0] * BEAMS[:, 1] - start[1] * BEAMS[:, 0]) / across
    return np.where((range_m > 0) & (share >= 0) & (share <= 1), range_m, np.inf)


def nearest_point(start: Floats, edge: Floats) -> float:
    """Distance from the laser to one edge [m]."""
    share = np.clip(-(start @ edge) / (edge @ edge), 0, 1)
    return float(np.hypot(*(start + share * edge)))


def objects(random: np.random.Generator, count: int) -> Iterator[Seen]:
    """Random objects that enough beams hit."""
    shapes = (face, box, cylinder)
    while count:
        seen = shapes[random.integers(len(shapes))](random)
        if np.isfinite(seen.ranges_m).sum() >= MIN_BEAMS:
            yield seen
            count -= 1


def measure(ranges_m: Floats, mixed: bool, random: np.random.Generator) -> Floats:
    """What the laser reports of an object."""
    hits = ranges_m[np.isfinite(ranges_m)]
    noisy = hits + random.normal(0, SIGMA_M, len(hits))
    kept = noisy[random.random(len(noisy)) >= DROPPED]
    if mixed:
        for edge in (0, -1):
            if random.random() < 0.5:
                kept[edge] += random.uniform(0, MIXED_M)
    return kept


def study(mixed: bool, count: int, seed: int) -> list[dict[str, object]]:
    """Bias, 95th percentile of the error and share within two sigmas, of every estimator on the same objects."""
    random = np.random.default_rng(seed)
    answers: dict[str, list[tuple[float, float]]] = {name: [] for name in ESTIMATORS}
    for seen in objects(random, count):
        ranges_m = measure(seen.ranges_m, mixed, random)
        for name, estimate in ESTIMATORS.items():
            range_m, sigma_m = estimate(ranges_m)
            answers[name].append((range_m - seen.nearest_m, sigma_m))
    return [summary(name, mixed, np.array(each)) for name, each in answers.items()]


def summary(name: str, mixed: bool, answers: Floats) -> dict[str, object]:
    """answers: errors and sigmas [m], float64[n, 2]."""
    error_m, sigma_m = answers.T
    return {
        "name": name,
        "edges": "mixed" if mixed else "clean",
        "objects": len(answers),
        "bias_mm": 1e3 * float(error_m.mean()),
        "p95_mm": 1e3 * float(np.percentile(np.abs(error_m), 95)),
        "within_2_sigma": float((np.abs(error_m) <= 2 * sigma_m).mean()),
    }


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.distance",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--objects", type=int, default=5000, help="how many (default: 5000)")
    parser.add_argument("--seed", type=int, default=0, help="of the objects and the noise")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), metavar="DIR", help="default: out/bench")
    args = parser.parse_args(argv)
    records = [record for mixed in (False, True) for record in study(mixed, args.objects, args.seed)]
    header = ("edges", "distance by", "bias", "95 % of errors below", "within 2 sigma")
    table = markdown(header, [_cells(record) for record in records])
    print(table)
    print(f"written to {write_results(args.out, 'distance', records, table)}", file=sys.stderr)
    return 0


def _cells(record: dict[str, object]) -> list[str]:
    return [
        str(record["edges"]),
        str(record["name"]),
        f"{record['bias_mm']:.1f} mm",
        f"{record['p95_mm']:.1f} mm",
        f"{100 * float(str(record['within_2_sigma'])):.1f} %",
    ]


if __name__ == "__main__":
    sys.exit(main())
