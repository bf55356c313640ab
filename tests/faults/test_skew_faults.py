# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""S1: scans and frames that were captured apart: refused beyond the tolerance, accepted within, and each says its skew.

From the sensors' loop through the real detector to what is read of it at the other end of the bus.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from edgefusion.config import CameraConfig, PerceptionConfig, SyncConfig
from edgefusion.messages.from_detections_detail import from_detections_detail
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.detector import Detector
from edgefusion.recording.folder import FolderRecording
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_loop import VisionLoop
from make_colour_network import open_colour_network
from scene import OBJECTS, write_recording
from vision_scenes import MS, Bench

PATIENT = CameraConfig(lost_s=9.0, read_timeout_s=9.0, frozen_s=9.0)
APART_NS = 1600 * MS
TOLERANCE_NS = round(SyncConfig().tolerance_s * 1e9)


class Skewed:
    """A scan and a frame of the same scene every 1.6 s, each scan by so much before its frame, or after it."""

    def __init__(self, folder: Path) -> None:
        self._recording = FolderRecording(write_recording(folder / "drive", seed=1))
        self._bench, self._shown = Bench(PATIENT), 0
        network = open_colour_network(folder / "network", {solid.name: solid.color for solid in OBJECTS})
        calibration = load_calibration(self._recording.calibration_path)
        detector = Detector(network, calibration, PerceptionConfig(max_object_width_m=1.2), clock=self._bench.clock)
        self._loop = VisionLoop(detector, self._bench.eye, self._bench.odometry, SyncConfig(), self._bench.clock)

    def looks(self, skew_ns: int) -> list[Look]:
        """All there are until 1.6 s later; skew_ns: the frame's stamp minus the scan's."""
        begin_ns = self._bench.clock.advance(APART_NS)
        events = sorted([(max(skew_ns, 0), self._frame), (max(-skew_ns, 0), self._scan)], key=lambda event: event[0])
        found = []
        for after_ns, happens in events:
            self._bench.clock.advance(begin_ns + after_ns - self._bench.clock())
            found.append(happens())
        return [look for look in found if look is not None]

    def _frame(self) -> Look | None:
        image = self._recording.frame(0).image.copy()
        image[0, :30] = self._shown = (self._shown + 40) % 250  # else the camera is frozen
        self._bench.camera.show(image)
        return self._loop.step([])

    def _scan(self) -> Look | None:
        return self._loop.step([replace(self._recording.scan(0), stamp_ns=self._bench.clock())])


@pytest.fixture(scope="module")
def skewed(tmp_path_factory: pytest.TempPathFactory) -> Skewed:
    it = Skewed(tmp_path_factory.mktemp("skew"))
    it.looks(0)  # with one interval of each stream known, no pair waits for a nearer one
    return it


@pytest.mark.parametrize("seed", range(20))
def test_s1_pairs_beyond_the_tolerance_are_refused_those_within_accepted_and_the_skew_stands_in_each_detection(
    skewed: Skewed, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    for skew_ns in (
        int(rng.integers(0, 500 * MS)),
        -int(rng.integers(0, 500 * MS)),
        int(rng.integers(0, TOLERANCE_NS)),
    ):
        looks = skewed.looks(skew_ns)
        assert len(looks) == (abs(skew_ns) <= TOLERANCE_NS)
        for look in looks:
            heard = to_detections_detail(from_detections_detail(look.frame.stamp_ns, look.detections)).detections
            assert {solid.name for solid in OBJECTS} == {detection.label for detection in heard}
            assert {detection.scan_frame_dt_ns for detection in (*look.detections, *heard)} == {skew_ns}


@pytest.mark.parametrize("beyond_ns", [0, 1])
@pytest.mark.parametrize("sign", [-1, 1])
def test_s1_the_tolerance_holds_to_the_nanosecond(skewed: Skewed, sign: int, beyond_ns: int) -> None:
    assert len(skewed.looks(sign * (TOLERANCE_NS + beyond_ns))) == 1 - beyond_ns
