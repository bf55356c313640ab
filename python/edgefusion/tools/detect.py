# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion detect`: the main job, on a recording."""

from __future__ import annotations

import argparse
import dataclasses
import resource
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterator

import msgspec

from edgefusion.errors import RefusedError

if TYPE_CHECKING:
    from edgefusion.config import Config, SyncConfig
    from edgefusion.perception.calibration import Calibration
    from edgefusion.perception.classifier import Classifier
    from edgefusion.perception.detector import Detector, StageTimes
    from edgefusion.perception.sync import Pair
    from edgefusion.recording.folder import FolderRecording
    from edgefusion.tools.results import ResultsFolder
    from edgefusion.types import Detection, Frame

EXAMPLES = """examples:
  edgefusion detect drive --model models/resnet18
  edgefusion detect drive --model models/resnet18 --objects 1 --images --out out/drive
  edgefusion detect drive --model net.onnx --labels labels.txt --calibration calibration.toml --json

RECORDING is a folder with images/000000.jpg ..., scans.npz and calibration.toml or .json.
Exit codes: 0 done, 2 refused input (what was written before stays)."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "detect",
        help="names and distances of the objects in a recording",
        description="Finds, names and measures the objects in front of the robot in a recorded drive.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="folder of a recorded drive")
    parser.add_argument("--model", type=Path, required=True, help="model folder, or an .onnx file with --labels")
    parser.add_argument("--labels", type=Path, help="one label per line, for a bare .onnx file")
    parser.add_argument("--calibration", type=Path, help="instead of the recording's own")
    parser.add_argument("--config", type=Path, help="TOML file with [perception] and [sync] settings")
    parser.add_argument("--objects", type=_count, metavar="N", help="the N nearest objects (the paper: 1)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the results (default: out/RECORDING)")
    parser.add_argument("--overwrite", action="store_true", help="replace results that DIR already holds")
    parser.add_argument("--images", action="store_true", help="write annotated images and pictures of the scans")
    parser.add_argument("--provider", default="auto", help="auto, tensorrt, cuda or cpu (default: auto)")
    parser.add_argument("--require", metavar="PROVIDER", help="refuse to run on any other provider")
    parser.add_argument("--threads", type=int, default=0, help="threads of the network (default: all cores)")
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")
    parser.set_defaults(run=run)


def _count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected at least 1, got {text}")
    return value


def run(args: argparse.Namespace) -> int:
    """Detects in a whole recording. Raises RefusedError."""
    from edgefusion.clock import system_clock
    from edgefusion.config import load_config
    from edgefusion.perception.calibration import load_calibration
    from edgefusion.perception.detector import Detector
    from edgefusion.recording.folder import FolderRecording
    from edgefusion.tools.results import ResultsFolder, free_folder

    config = load_config(args.config)
    if args.objects is not None:
        perception = msgspec.structs.replace(config.perception, objects=args.objects)
        config = msgspec.structs.replace(config, perception=perception)
    recording = FolderRecording(args.recording)
    calibration = load_calibration(args.calibration or recording.calibration_path)
    classifier = _open_classifier(args)
    detector = Detector(classifier, calibration, config.perception, clock=system_clock)
    out = args.out or free_folder(Path("out"), args.recording.resolve().name)
    with ResultsFolder(out, args.overwrite) as results:
        tally = detect_all(recording, detector, calibration, config, results, args.images)
        summary = {"provider": classifier.provider, **tally.summary(out)}
        results.write_summary(summary)
    print(msgspec.json.encode(summary).decode() if args.json else _as_text(summary))
    return 0


def _open_classifier(args: argparse.Namespace) -> Classifier:
    from edgefusion.perception.classifier import open_classifier
    from edgefusion.perception.network import RuntimeOptions

    options = RuntimeOptions(provider=args.provider, require=args.require, threads=args.threads)
    return open_classifier(args.model, labels=args.labels, options=options)


def detect_all(
    recording: FolderRecording,
    detector: Detector,
    calibration: Calibration,
    config: Config,
    results: ResultsFolder,
    images: bool,
) -> Tally:
    """Every frame of a recording through the detector, into the results as it goes."""
    from tqdm import tqdm

    from edgefusion.perception.clusters import find_clusters
    from edgefusion.tools.draw import annotate, draw_scan

    tally = Tally()
    pairs = _captured_together(recording, calibration, config.sync)
    for pair in tqdm(pairs, total=len(recording), unit="frame", disable=None, file=sys.stderr):
        index = recording.frame_index(pair.frame.stamp_ns + calibration.camera_latency_ns)
        _check_size(recording, index, pair.frame, calibration)
        detections = detector.detect(pair.scan, pair.frame)
        results.write_detections(index, detections)
        tally.add(detections, detector.times)
        if images:
            clusters = find_clusters(pair.scan, config.perception)
            picture = annotate(pair.frame.image, detections, pair.scan, clusters, calibration)
            results.write_image(f"annotated/{index:06d}.jpg", picture)
            results.write_image(f"scans/{index:06d}.png", draw_scan(pair.scan, clusters, detections))
    return tally


def _captured_together(recording: FolderRecording, calibration: Calibration, config: SyncConfig) -> Iterator[Pair]:
    """Scans and frames of the recording, paired by when they were captured."""
    from edgefusion.perception.sync import Synchronizer
    from edgefusion.types import Scan

    sync = Synchronizer(tolerance_ns=round(config.tolerance_s * 1e9), horizon_ns=round(config.horizon_s * 1e9))
    for message in recording.messages():
        if isinstance(message, Scan):
            captured_ns = message.stamp_ns - calibration.laser_latency_ns
            yield from sync.add_scan(dataclasses.replace(message, stamp_ns=captured_ns))
        else:
            captured_ns = message.stamp_ns - calibration.camera_latency_ns
            yield from sync.add_frame(dataclasses.replace(message, stamp_ns=captured_ns))
    yield from sync.flush()


def _check_size(recording: FolderRecording, index: int, frame: Frame, calibration: Calibration) -> None:
    height, width = frame.image.shape[:2]
    if (width, height) != calibration.image_size:
        expected = "x".join(map(str, calibration.image_size))
        raise RefusedError(
            f"{recording.image_path(index)}: the calibration is for {expected}, the image is {width}x{height}"
        )


class Tally:
    """Counts what was found and how long it took."""

    def __init__(self) -> None:
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
            "detections": sum(self._labels.values()),
            "labels": dict(self._labels.most_common()),
            "median_ms": self._median_ms(),
            "peak_memory_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024),
        }

    def _median_ms(self) -> dict[str, float]:
        import numpy as np

        if not self._times:
            return {}
        stages = [field.name for field in dataclasses.fields(self._times[0])]
        rows = np.array([[getattr(times, stage) for stage in stages] for times in self._times]) / 1e6
        medians = {stage[: -len("_ns")]: round(float(m), 3) for stage, m in zip(stages, np.median(rows, axis=0))}
        return {**medians, "whole_frame": round(float(np.median(rows.sum(axis=1))), 3)}


def _as_text(summary: dict[str, Any]) -> str:
    found = ", ".join(f"{label} {n}" for label, n in list(summary["labels"].items())[:8])
    stages = ", ".join(f"{stage} {ms:g}" for stage, ms in summary["median_ms"].items())
    return "\n".join(
        [
            f"{summary['frames']} frames, {summary['detections']} detections on {summary['provider']}",
            f"found:           {found or 'nothing'}",
            f"median ms:       {stages}",
            f"peak memory:     {summary['peak_memory_mb']} MB",
            f"results:         {summary['out']}",
        ]
    )
