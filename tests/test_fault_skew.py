# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""S1's line in the table of faults: what is right counts as right there, and what is wrong as wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.faults_skew import Skews, open_detector, skewed

from edgefusion.config import SyncConfig
from edgefusion.perception.detector import Detector, StageTimes
from edgefusion.service.vision_loop import Detects
from edgefusion.service.vision_pairing import NewestPair
from edgefusion.types import STILL, Detection, Frame, Pose2D, Scan

FEW, TOLERANCE_NS = 12, 100_000_000


@pytest.fixture(scope="module")
def detector() -> Detector:
    return open_detector()


class Blind:
    """It finds nothing."""

    times = StageTimes(0, 0, 0, 0)

    def detect(self, scan: Scan, frame: Frame, motion: Pose2D = STILL) -> list[Detection]:
        return []


class Forgetful:
    """It does not say how far scan and frame are apart."""

    def __init__(self, detector: Detector) -> None:
        self._detector, self.times = detector, detector.times

    def detect(self, scan: Scan, frame: Frame, motion: Pose2D = STILL) -> list[Detection]:
        return [replace(each, scan_frame_dt_ns=7) for each in self._detector.detect(scan, frame, motion)]


def judged(detector: Detects, tolerance_s: float = 0.1) -> Skews:
    pairing = NewestPair(SyncConfig(tolerance_s=tolerance_s))
    return skewed(np.random.default_rng(0), FEW, detector, pairing, TOLERANCE_NS)


def test_s1_every_pair_is_treated_as_its_skew_demands_which_stands_in_each_detection(detector: Detector) -> None:
    run = judged(detector)
    assert (run.wrong, run.untold, run.accepted + run.refused) == (0, 0, FEW)
    assert min(run.accepted, run.refused) > 0
    assert run.told >= run.accepted


def test_pairs_beyond_the_tolerance_and_a_skew_that_is_not_told_are_counted(detector: Detector) -> None:
    assert judged(Blind(), tolerance_s=0.4).wrong > 0
    assert judged(Blind(), tolerance_s=0.05).wrong > 0
    forgotten = judged(Forgetful(detector))
    assert (forgotten.told, forgotten.untold > 0) == (0, True)


def test_runs_add_up() -> None:
    total = Skews(1, 2, 3, 4, 5)
    total.add(Skews(10, 20, 30, 40, 50))
    assert total == Skews(11, 22, 33, 44, 55)
