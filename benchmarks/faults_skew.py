# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""S1: scans and frames captured up to half a second apart: which of them are paired, and what their detections say.

It is about stamps alone: nothing here waits.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Sequence

import numpy as np
from benchmarks.fault_row import FaultRow
from benchmarks.faults_inference import CALIBRATION

from edgefusion.config import SyncConfig
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.service.vision_loop import Detects
from edgefusion.service.vision_pairing import NewestPair
from edgefusion.tools.arguments import LAB_MODEL
from edgefusion.types import Detection, Frame, Scan

PAIRS = 100
"""Of a run."""
MOST_NS, APART_NS = 500_000_000, 1_600_000_000
_SIZE = 640, 480

Rng = np.random.Generator


@dataclass
class Skews:
    """accepted, refused: how many, rightly. wrong: how many were treated otherwise than their skew demands. told: how
    many detections said their skew, at the other end of the bus; untold: how many another one."""

    accepted: int = 0
    refused: int = 0
    wrong: int = 0
    told: int = 0
    untold: int = 0

    def add(self, other: Skews) -> None:
        for name, count in vars(other).items():
            setattr(self, name, getattr(self, name) + count)


def skewed(rng: Rng, pairs: int, detector: Detects, pairing: NewestPair, tolerance_ns: int) -> Skews:
    """So many, half of them within 2 ns of the tolerance; the same generator gives the same."""
    run = Skews()
    image = rng.integers(0, 255, (_SIZE[1], _SIZE[0], 3), dtype=np.uint8)
    for number in range(pairs + 1):  # with the first the pace of both streams is known, and no pair waits
        skew_ns = _skew_ns(rng, number, tolerance_ns) if number else 0
        scan_ns = (number + 1) * APART_NS + max(-skew_ns, 0)
        scan, frame = _scan(rng, scan_ns), Frame(scan_ns + skew_ns, image)
        first, last = ((scan,), ()), ((), (frame,))
        found = [pairing.add(*came) for came in ((first, last) if skew_ns >= 0 else (last, first))]
        pair = found[0] or found[1]
        if number:
            run.add(_judged(skew_ns, tolerance_ns, None if pair is None else detector.detect(*pair)))
    return run


def rows(seeds: int, tick: Callable[[], object] = lambda: None) -> list[FaultRow]:
    """The figure, of so many runs. tick: called after each."""
    config, found = SyncConfig(), Skews()
    detector, tolerance_ns = open_detector(), round(config.tolerance_s * 1e9)
    for seed in range(seeds):
        found.add(skewed(np.random.default_rng(seed), PAIRS, detector, NewestPair(config), tolerance_ns))
        tick()
    remark = (
        f"{found.accepted} accepted, {found.refused} refused, {found.wrong} the other way round; "
        f"{found.told} detections say their skew, {found.untold} another"
    )
    what = f"scans and frames up to {MOST_NS / 1e6:.0f} ms apart, half of them around {config.tolerance_s * 1e3:g} ms"
    aim = f"within {config.tolerance_s * 1e3:g} ms accepted, beyond refused"
    failed = found.wrong + found.untold > 0 or not (found.accepted and found.refused and found.told)
    return [FaultRow("S1", what, aim, math.inf, remark=remark, failed=failed)]


def open_detector() -> Detector:
    """With the simulator's own classifier."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "calibration.toml"
        file.write_text(CALIBRATION, encoding="utf-8")
        return Detector(open_classifier(LAB_MODEL), load_calibration(file))


def _judged(skew_ns: int, tolerance_ns: int, detections: Sequence[Detection] | None) -> Skews:
    """detections: of the pair, None where there was none."""
    within = abs(skew_ns) <= tolerance_ns
    if within != (detections is not None):
        return Skews(wrong=1)
    if detections is None:
        return Skews(refused=1)
    heard = to_detections_detail(from_detections_detail(0, detections)).detections
    told = sum(detection.scan_frame_dt_ns == skew_ns for detection in heard)
    return Skews(accepted=1, told=told, untold=max(len(heard), len(detections)) - told)


def _skew_ns(rng: Rng, number: int, tolerance_ns: int) -> int:
    """The frame's stamp minus the scan's."""
    if number % 2:
        return int(rng.integers(-MOST_NS, MOST_NS))
    return int(rng.choice((-1, 1))) * (tolerance_ns + int(rng.integers(-2, 3)))


def _scan(rng: Rng, stamp_ns: int) -> Scan:
    """A wall, and half a metre of something before it."""
    ranges_m = np.full(361, 8.0, np.float32)
    begin = int(rng.integers(150, 190))
    ranges_m[begin : begin + 28] = rng.uniform(1.5, 2.5)
    return Scan(stamp_ns, ranges_m, -math.pi / 2, math.radians(0.5))
