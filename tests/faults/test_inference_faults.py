# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""I3, I4: answers and boxes that are none cost only themselves; a network ten times slower gets the newest frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.detector import Detector
from edgefusion.perception.network import Network
from edgefusion.recording.folder import FolderRecording
from edgefusion.types import Detection, Scan
from make_colour_network import open_colour_network
from scene import HEIGHT, OBJECTS, WIDTH, write_recording
from vision_scenes import MS, Bench

NAMES = {solid.name for solid in OBJECTS}
SEEDS = range(20)
NONE = (np.nan, np.inf, -np.inf)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> FolderRecording:
    return FolderRecording(write_recording(tmp_path_factory.mktemp("scene") / "drive", seed=1))


@pytest.fixture(scope="module")
def detector(recording: FolderRecording, tmp_path_factory: pytest.TempPathFactory) -> Detector:
    network = open_colour_network(tmp_path_factory.mktemp("network"), {solid.name: solid.color for solid in OBJECTS})
    config = PerceptionConfig(max_object_width_m=1.2, objects=40)
    return Detector(network, load_calibration(recording.calibration_path), config)


def seen(detector: Detector, recording: FolderRecording, scan: Scan | None = None) -> list[Detection]:
    return detector.detect(recording.scan(0) if scan is None else scan, recording.frame(0))


class SpoiltAnswers:
    """Of every network from now on: numbers that are none, one or all of a row's, in some rows. lost: which rows."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator, share: float) -> None:
        self._run, self._rng, self._share = Network.run, rng, share
        self.lost: list[bool] = []
        monkeypatch.setattr(Network, "run", lambda network, batch: self._spoilt(self._run(network, batch)))

    def _spoilt(self, outputs: np.ndarray) -> np.ndarray:
        lost = self._rng.random(len(outputs)) < self._share
        self.lost = lost.tolist()
        for row in np.flatnonzero(lost):
            which = slice(None) if self._rng.random() < 0.5 else int(self._rng.integers(outputs.shape[1]))
            outputs[row, which] = self._rng.choice(NONE)
        return outputs


@pytest.mark.parametrize("share", [0.3, 0.9])
@pytest.mark.parametrize("seed", SEEDS)
def test_i3_boxes_whose_answers_are_no_numbers_are_dropped_and_the_others_voted(
    detector: Detector, recording: FolderRecording, monkeypatch: pytest.MonkeyPatch, seed: int, share: float
) -> None:
    clean = seen(detector, recording)
    spoilt = SpoiltAnswers(monkeypatch, np.random.default_rng(seed), share)
    found = {detection.cluster.indices[0]: detection for detection in seen(detector, recording)}
    lost = iter(spoilt.lost)
    for before in sorted(clean, key=lambda each: each.cluster.range_m):
        kept = [not next(lost) for _ in before.boxes]
        now = found.pop(before.cluster.indices[0], None)
        assert (now is not None) == any(kept)
        if now is not None:
            assert now.vote.top5 == tuple(top if keep else () for top, keep in zip(before.vote.top5, kept))
            assert now.distance_m == before.distance_m
    assert not found
    assert next(lost, None) is None


def spoilt_scan(scan: Scan, free: np.ndarray, rng: np.random.Generator) -> Scan:
    """With things where nothing of the scene is: too far for a pixel, at the lens, beside the picture, nowhere."""
    ranges_m = scan.ranges_m.copy()
    for _ in range(12):
        begin = int(rng.integers(0, len(ranges_m) - 8))
        beams = np.arange(begin, begin + int(rng.integers(1, 8)))
        ranges_m[beams[free[beams]]] = rng.choice([*NONE, 0.0, -1.0, 1e-6, 0.02, 0.06, 3.0, 29.0, 79.0, 1e30])
    return replace(scan, ranges_m=ranges_m)


@pytest.mark.parametrize("seed", SEEDS)
def test_i3_boxes_without_a_pixel_or_out_of_the_image_are_dropped_and_the_others_voted(
    detector: Detector, recording: FolderRecording, seed: int
) -> None:
    scan = recording.scan(0)
    free = np.ones(len(scan.ranges_m), bool)
    for detection in seen(detector, recording):
        first, last = detection.cluster.indices[[0, -1]]
        free[max(0, first - 5) : last + 6] = False
    found = seen(detector, recording, spoilt_scan(scan, free, np.random.default_rng(seed)))
    assert {detection.label for detection in found} >= NAMES
    for x0, y0, x1, y1 in (box for detection in found for box in (detection.box, *detection.boxes)):
        assert 0 <= x0 < x1 <= WIDTH
        assert 0 <= y0 < y1 <= HEIGHT


def test_i4_a_network_that_gets_ten_times_slower_looks_at_the_newest_and_has_caught_up_when_it_is_fast_again() -> None:
    bench, usual_ms = Bench(frame_ms=40, scan_ms=80, late_ms=20), 40
    waited_ms = 40 + 80 + 20 + 5  # for a frame, its scan, the scan's way, and a turn
    for slower in (1, 10, 1):
        latency_ms = slower * usual_ms
        bench.detector.meanwhile = lambda ms=latency_ms: bench.pass_ms(ms)
        overtaken = bench.loop.overtaken
        looks = bench.look_for(8000)
        assert len(looks) >= 0.9 * 8000 / (latency_ms + 85)
        assert all(look.begun_ns - look.frame.stamp_ns <= waited_ms * MS for look in looks)
        assert all(look.age_ns <= max(2 * latency_ms, latency_ms + waited_ms) * MS for look in looks)
        assert (bench.loop.overtaken - overtaken > 30) == (slower > 1)
