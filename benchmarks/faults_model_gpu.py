# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A GPU that is lost, at the start or while it runs: I2, with one that really is the CPU."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Callable, Tuple

import numpy as np
import numpy.typing as npt
from benchmarks.fault_row import FaultRow
from benchmarks.lost_gpu import LostGpu, lost_gpu

from edgefusion.clock import system_clock
from edgefusion.errors import RefusedError
from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.detector import StageTimes
from edgefusion.perception.network import RuntimeOptions
from edgefusion.perception.preprocessing import Boxes
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_state import Circumstances, VisionState
from edgefusion.types import Frame, HealthState, Pose2D, Scan

TOLERANCE = 1e-3
_BOXES = 32
_CUDA = RuntimeOptions(provider="cuda")

Tick = Callable[[], object]


def lost(model: Path, seeds: int, tick: Tick) -> FaultRow:
    """I2, while it runs."""

    def seconds(gpu: LostGpu, seed: int) -> Tuple[float, Classifier]:
        opened = open_classifier(model, options=_CUDA)
        opened.probabilities(*_crops(seed))
        gpu.runs = 0
        begun_s = time.monotonic()
        opened.probabilities(*_crops(seed))
        return time.monotonic() - begun_s, opened

    return _row(model, f"{model.name}: GPU lost at a run, until the CPU answers", True, seconds, seeds, tick)


def gone(model: Path, seeds: int, tick: Tick) -> FaultRow:
    """I2, from the start."""

    def seconds(_: LostGpu, seed: int) -> Tuple[float, Classifier]:
        begun_s = time.monotonic()
        opened = open_classifier(model, options=_CUDA)
        opened.probabilities(*_crops(seed))
        return time.monotonic() - begun_s, opened

    return _row(model, f"{model.name}: GPU gone at the start, until the CPU answers", False, seconds, seeds, tick)


def _row(
    model: Path,
    what: str,
    starts: bool,
    timed: Callable[[LostGpu, int], Tuple[float, Classifier]],
    seeds: int,
    tick: Tick,
) -> FaultRow:
    reference, times, worst, others = open_classifier(model), [], 0.0, 0
    degraded = required = 0
    for seed in range(seeds):
        with lost_gpu(starts) as gpu:
            seconds, opened = timed(gpu, seed)
            required += _is_required(model, gpu)
        times.append(seconds)
        got, expected = (each.probabilities(*_crops(seed)) for each in (opened, reference))
        worst = max(worst, float(np.abs(got - expected).max()))
        others += int((got.argmax(axis=1) != expected.argmax(axis=1)).sum())
        degraded += _is_degraded(opened.provider_note)
        tick()
    failed = worst > TOLERANCE or others > 0 or degraded < seeds or required < seeds
    remark = (
        f"{others} labels differ, scores by {worst:.1g} at most; {degraded} of {seeds} said DEGRADED, "
        f"{required} of {seeds} ended where it is required"
    )
    return FaultRow("I2", what, "2 s, the same labels, scores within 1e-3, DEGRADED", 2.0, times, remark, failed)


def _is_required(model: Path, gpu: LostGpu) -> bool:
    """Whether one that must not be stood in for is not."""
    gpu.runs = 1  # the golden answer
    try:
        open_classifier(model, options=RuntimeOptions(require="cuda")).probabilities(*_crops(0))
    except (RefusedError, RuntimeError):
        return True
    return False


def _is_degraded(note: str) -> bool:
    """Whether vision, which sees, says so."""
    now_ns = system_clock()
    state = VisionState(now_ns, 0.1)
    scan, frame = Scan(now_ns, np.ones(1, np.float32), 0.0, 0.01), Frame(now_ns, _crops(0)[0])
    state.looked(Look(scan, frame, Pose2D(), (), StageTimes(0, 0, 0, 0), now_ns, now_ns))
    return state.health(now_ns, Circumstances(note=note)).state is HealthState.DEGRADED


def _crops(seed: int) -> Tuple[npt.NDArray[np.uint8], Boxes]:
    """A picture, and as many boxes as a frame of three objects has."""
    rng = np.random.default_rng(seed)
    picture = rng.integers(0, 256, (480, 640, 3), np.uint8)
    corners = rng.integers(0, 400, (_BOXES, 2))
    return picture, np.hstack([corners, corners + rng.integers(20, 80, (_BOXES, 2))])
