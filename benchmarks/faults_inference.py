# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""I3 and I4 with the real network: answers and boxes that are none, and inference that takes ten times as long."""

from __future__ import annotations

import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Callable, Iterator, List, NamedTuple, Tuple

import numpy as np
import numpy.typing as npt
from benchmarks.fault_row import FaultRow
from benchmarks.faults_base_rig import BaseRig, hall
from benchmarks.faults_camera_rig import CameraRig

from edgefusion.bus.client import Robot
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.network import Network
from edgefusion.tools.arguments import LAB_MODEL
from edgefusion.types import Detection, Frame, Pose2D, Scan

FRAMES, SLOWER, USUAL = 20, 10, 1
_WATCHED_S, _WARM = 8.0, 2
_SIZE = 640, 480
CALIBRATION = """
version = 1
image_size = [640, 480]
K = [[460.0, 0, 319.5], [0, 460.0, 239.5], [0, 0, 1]]
T_camera_laser = [[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]
laser_height_m = 0.25
"""
_VISION = """
[camera]
source = "{url}"
[vision]
model = "{model}"
calibration = "calibration.toml"
"""
_NONE = (np.nan, np.inf, -np.inf)
_ODD_M = (*_NONE, 0.0, -1.0, 1e-6, 0.02, 0.06, 29.0, 79.0, 1e30)

Tick = Callable[[], object]
Rng = np.random.Generator


def rows(seeds: int, tick: Tick = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each run."""
    return [*_nothing(seeds, tick), *_slow(seeds, tick)]


def _nothing(seeds: int, tick: Tick) -> List[FaultRow]:
    """I3."""
    spoilt = found = wrong = raised = 0
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        with _detector(rng) as (detector, lost):
            for _ in range(FRAMES):
                lost.clear()
                frame = Frame(0, rng.integers(0, 255, (_SIZE[1], _SIZE[0], 3), dtype=np.uint8))
                try:
                    detections = detector.detect(_odd_scan(rng), frame, _odd_motion(rng))
                except Exception:
                    raised += 1
                    continue
                spoilt, found = spoilt + sum(lost), found + len(detections)
                wrong += sum(not _is_well(detection) for detection in detections)
        tick()
    frames = f"{FRAMES * seeds} frames with scans, motions and answers that are none"
    remark = (
        f"{raised} exceptions, {found} objects named by the boxes left of {spoilt} without an answer, {wrong} wrong"
    )
    aim = "no exception, no box out of the image"
    return [FaultRow("I3", frames, aim, float("inf"), [], remark, raised + wrong > 0 or not found)]


@contextmanager
def _detector(rng: Rng) -> Iterator[Tuple[Detector, List[bool]]]:
    """With the real network, of whose answers each third is spoilt; which of the last ones were."""
    lost: List[bool] = []
    run = Network.run

    def spoilt(network: Network, batch: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        outputs = run(network, batch)
        lost[:] = (rng.random(len(outputs)) < 1 / 3).tolist()
        outputs[np.array(lost, bool), int(rng.integers(outputs.shape[1]))] = rng.choice(_NONE)
        return outputs

    with hall(0, ()) as rig:
        (rig.folder / "calibration.toml").write_text(CALIBRATION, encoding="utf-8")
        detector = Detector(open_classifier(LAB_MODEL), load_calibration(rig.folder / "calibration.toml"))
    setattr(Network, "run", spoilt)  # noqa: B010
    try:
        yield detector, lost
    finally:
        setattr(Network, "run", run)  # noqa: B010


def _odd_scan(rng: Rng) -> Scan:
    """Pieces of surfaces at all distances, and things that are no distance."""
    ranges_m = np.repeat(rng.uniform(0.3, 8.0, 46), 8)[:361]
    for _ in range(12):
        begin = int(rng.integers(0, 353))
        ranges_m[begin : begin + int(rng.integers(1, 9))] = rng.choice(_ODD_M)
    return Scan(0, ranges_m.astype(np.float32), -np.pi / 2, np.radians(0.5))


def _odd_motion(rng: Rng) -> Pose2D:
    return Pose2D(*(float(value) for value in rng.normal(0, 0.3, 3)))


def _is_well(detection: Detection) -> bool:
    width, height = _SIZE
    boxes = (detection.box, *detection.boxes)
    inside = all(0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height for x0, y0, x1, y1 in boxes)
    return inside and bool(np.isfinite([detection.score, detection.distance_m, detection.bearing]).all())


class _Looks(NamedTuple):
    """took_s: each look. waited_s: each frame, until it was looked at. overtaken: how many pairs nobody looked at.
    late_s: 99 of 100 cycles of base were late by no more."""

    took_s: List[float]
    waited_s: List[float]
    overtaken: int
    late_s: float


def _slow(seeds: int, tick: Tick) -> List[FaultRow]:
    """I4."""
    usual: List[_Looks] = []
    slow: List[_Looks] = []
    for seed in range(seeds):
        for looks, times in ((usual, USUAL), (slow, SLOWER)):
            looks.append(_watched(seed, times))
        tick()
    took_s, usual_s = (median(took for run in runs for took in run.took_s) for runs in (slow, usual))
    overtaken = sum(run.overtaken for run in slow)
    remark = f"{1e3 * took_s:.0f} ms instead of {1e3 * usual_s:.0f} ms; {overtaken} pairs overtaken by newer ones"
    aim, waited = f"as long as inference takes, {1e3 * took_s:.0f} ms", [s for run in slow for s in run.waited_s]
    late = [run.late_s for run in slow]
    return [
        FaultRow("I4", "inference ten times slower, age of a frame that is looked at", aim, took_s, waited, remark),
        FaultRow("I4", "base meanwhile, 99 of 100 cycles late by", "25 ms", 0.025, late),
    ]


def _watched(seed: int, times: int) -> _Looks:
    """A base that drives beside such a vision."""
    with CameraRig(seed) as camera, hall(seed) as rig:
        config = rig.folder / "robot.toml"
        (rig.folder / "calibration.toml").write_text(CALIBRATION, encoding="utf-8")
        vision = config.read_text(encoding="utf-8") + _VISION.format(url=camera.url, model=LAB_MODEL)
        config.write_text(vision, encoding="utf-8")
        for verb in ("bus", "base"):
            rig.start(verb)
        client = rig.connect()
        rig.drive(client)
        lines = _looks(config, times)
        return _counted(lines[_WARM:], _late_s(rig, client))


def _looks(config: Path, times: int) -> List[List[int]]:
    """Of a vision in a process of its own, from its first look on for a while."""
    command = [sys.executable, "-m", "benchmarks.slow_vision", str(config), str(times)]
    lines: List[List[int]] = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            assert process.stdout is not None
            end_s = float("inf")
            while time.monotonic() < end_s:
                line = process.stdout.readline()
                if not line:
                    raise RuntimeError("slow_vision: expected looks, it ended")
                lines.append([int(word) for word in line.split()])
                end_s = min(end_s, time.monotonic() + _WATCHED_S)
        finally:
            process.kill()
    return lines


def _late_s(rig: BaseRig, client: Robot) -> float:
    figures = next(each.figures for each in client.status.healths if each.health.component == "base")
    return float(figures["lateness p99 [ms]"]) / 1e3


def _counted(lines: List[List[int]], late_s: float) -> _Looks:
    took = [(ended - begun) / 1e9 for _, begun, ended, _ in lines]
    waited = [(begun - frame) / 1e9 for frame, begun, _, _ in lines]
    return _Looks(took, waited, lines[-1][3] - lines[0][3], late_s)
