# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A whole recording through the detector: what `edgefusion detect` does."""

from __future__ import annotations

import dataclasses
import resource
import sys
from collections import Counter
from pathlib import Path
from typing import AbstractSet, Any, Iterator

import numpy as np
from tqdm import tqdm

from edgefusion.config import Config, SyncConfig
from edgefusion.errors import RefusedError
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.clusters import find_clusters
from edgefusion.perception.detector import Detector, StageTimes
from edgefusion.perception.sync import Pair, Synchronizer
from edgefusion.recording.recording import Recording
from edgefusion.tools.draw import annotate, draw_scan
from edgefusion.tools.results import ResultsFolder
from edgefusion.types import Detection, Frame, Scan


def detect_all(
    recording: Recording,
    detector: Detector,
    calibration: Calibration,
    config: Config,
    results: ResultsFolder,
    images: bool,
    wanted: AbstractSet[str] = frozenset(),
) -> Tally:
    """Every frame of a recording through the detector, into the results as it goes; only `wanted` labels, if any.

    Raises RefusedError where no scan and frame were captured together.
    """
    tally = Tally()
    pairs = CapturedTogether(recording, calibration, config.sync)
    for index, pair in tqdm(pairs, total=recording.frames, unit="frame", disable=None, file=sys.stderr):
        check_size(recording, index, pair.frame, calibration)
        detections = [d for d in detector.detect(pair.scan, pair.frame) if not wanted or d.label in wanted]
        results.write_detections(index, detections)
        tally.add(detections, detector.times)
        if images:
            clusters = find_clusters(pair.scan, config.perception)
            picture = annotate(pair.frame.image, detections, pair.scan, clusters, calibration)
            results.write_image(f"annotated/{index:06d}.jpg", picture)
            results.write_image(f"scans/{index:06d}.png", draw_scan(pair.scan, clusters, detections))
    pairs.check_any()
    tally.sync = pairs.counts()
    return tally


class CapturedTogether:
    """The scans and frames of a recording, paired by when they were captured; each pair with the frame's number."""

    def __init__(self, recording: Recording, calibration: Calibration, config: SyncConfig) -> None:
        self._recording, self._calibration, self._config = recording, calibration, config
        self._sync = Synchronizer(round(config.tolerance_s * 1e9), round(config.horizon_s * 1e9))
        self._scans_ns: list[int] = []
        self._frames_ns: list[int] = []
        self._numbers: dict[int, int] = {}

    def __iter__(self) -> Iterator[tuple[int, Pair]]:
        latencies = self._calibration.laser_latency_ns, self._calibration.camera_latency_ns
        for message in self._recording.messages(*latencies):
            yield from self._numbered(self._add(message))
        yield from self._numbered(self._sync.flush())

    def _add(self, message: Scan | Frame) -> list[Pair]:
        if isinstance(message, Scan):
            self._scans_ns.append(message.stamp_ns)
            return self._sync.add_scan(message)
        self._numbers.setdefault(message.stamp_ns, len(self._frames_ns))
        self._frames_ns.append(message.stamp_ns)
        return self._sync.add_frame(message)

    def _numbered(self, pairs: list[Pair]) -> Iterator[tuple[int, Pair]]:
        for pair in pairs:
            yield self._numbers.pop(pair.frame.stamp_ns), pair

    def counts(self) -> dict[str, int]:
        """How many scans and frames ended how; those that waited to the end are without partner."""
        counts = Counter(self._sync.counts)
        for kind, came in (("scan", self._scans_ns), ("frame", self._frames_ns)):
            ended = sum(number for name, number in counts.items() if name.startswith(kind))
            counts[f"{kind} without partner"] += len(came) - ended
        return {name: number for name, number in sorted(counts.items()) if number}

    def check_any(self) -> None:
        """Raises RefusedError where there was not a single pair."""
        if self._sync.counts.get("frame paired"):
            return
        path = self._recording.path
        if not self._scans_ns or not self._frames_ns:
            raise RefusedError(
                f"{path}: expected scans and frames, found {len(self._scans_ns)} and {len(self._frames_ns)}"
            )
        raise RefusedError(
            f"{path}: no frame within tolerance_s = {self._config.tolerance_s:g} s of a scan: "
            f"the nearest are {self._smallest_difference_ns() / 1e9:g} s apart (stamps less latencies)"
        )

    def _smallest_difference_ns(self) -> int:
        scans_ns, frames_ns = np.array(sorted(self._scans_ns)), np.array(self._frames_ns)
        after = np.searchsorted(scans_ns, frames_ns)
        around = [scans_ns[np.clip(after + step, 0, len(scans_ns) - 1)] for step in (-1, 0)]
        return int(np.abs(np.stack(around) - frames_ns).min())


def check_size(recording: Recording, index: int, frame: Frame, calibration: Calibration) -> None:
    """Raises RefusedError where a frame is not of the size that the calibration is for."""
    height, width = frame.image.shape[:2]
    if (width, height) != calibration.image_size:
        expected = "x".join(map(str, calibration.image_size))
        raise RefusedError(
            f"{recording.frame_name(index)}: the calibration is for {expected}, the image is {width}x{height}"
        )


class Tally:
    """Counts what was found and how long it took. sync: how many scans and frames ended how."""

    def __init__(self) -> None:
        self.sync: dict[str, int] = {}
        self._times: list[StageTimes] = []
        self._labels: Counter[str] = Counter()

    def add(self, detections: list[Detection], times: StageTimes) -> None:
        """One more frame."""
        self._times.append(times)
        self._labels.update(detection.group or detection.label for detection in detections)

    def summary(self, out: Path) -> dict[str, Any]:
        """What the run found, as plain values."""
        return {
            "out": str(out),
            "frames": len(self._times),
            "sync": self.sync,
            "detections": sum(self._labels.values()),
            "labels": dict(self._labels.most_common()),
            "median_ms": self._median_ms(),
            "peak_memory_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024),
        }

    def _median_ms(self) -> dict[str, float]:
        stages = [field.name for field in dataclasses.fields(StageTimes)]
        rows = np.array([[getattr(times, stage) for stage in stages] for times in self._times]) / 1e6
        medians = {stage[: -len("_ns")]: round(float(m), 3) for stage, m in zip(stages, np.median(rows, axis=0))}
        return {**medians, "whole_frame": round(float(np.median(rows.sum(axis=1))), 3)}
