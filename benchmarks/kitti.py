# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How well the car ahead is found, boxed and measured on a real drive: edgefusion beside the plain pipeline.

Frames 0 to 29 of ../shared/data/kitti-drive with a MobileNetV2 and the 8 nearest objects, against boxes and distances
from the full 3D cloud, which the scan does not contain. The car ahead is the detection whose distance is nearest to
the true one. "best IoU" is that of the best of its candidate boxes: what another choice among them could reach. The
true distance is the scan's minimum, so that min(r), the plain pipeline's, has no error by construction; edgefusion's
corrects for noise that this laser hardly has. A measurement: nothing is tuned here.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
from dataclasses import asdict, dataclass
from itertools import product as product_of
from pathlib import Path
from typing import Callable, Iterator, Literal, NamedTuple, Sequence, Tuple

import cv2
import msgspec
import numpy as np
import onnxruntime
from benchmarks.plain import HEIGHTS, SIZE, Found, Pixels, PlainPipeline, Resize, by_pillow, network, read_geometry
from benchmarks.run import markdown, write_results

from edgefusion.config import USUAL_HEIGHTS, PerceptionConfig
from edgefusion.perception.calibration import load_calibration
from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.groups import LabelGroups
from edgefusion.perception.preprocessing import Fit
from edgefusion.recording.folder import FolderRecording
from edgefusion.types import Detection

EXAMPLES = """examples:
  python -m benchmarks.kitti
  python -m benchmarks.kitti --frames 5"""

SHARED = Path(__file__).resolve().parents[2] / "shared" / "data"
DRIVE = SHARED / "kitti-drive"
MODEL = SHARED / "models" / "mobilenetv2_fp32_dequant.onnx"
LABELS = SHARED / "models" / "imagenet_classes.txt"
OBJECTS = 8
Rule = Literal["paper", "weighted"]

DEFAULTS = PerceptionConfig()
RULES: Sequence[Rule] = ("paper", "weighted")
FITS: Sequence[Fit] = ("squash", "square-context", "letterbox")

Edges = Sequence[float]


class Setting(NamedTuple):
    """What is varied."""

    heights: Tuple[float, ...]
    rule: Rule
    fit: Fit

    def __str__(self) -> str:
        return f"heights {', '.join(map(str, self.heights))}, {self.rule}, {self.fit}"


@dataclass(frozen=True)
class Truth:
    """The car ahead in one frame."""

    frame: int
    box: Edges
    distance_m: float
    bearing: float


@dataclass(frozen=True)
class Answer:
    """One detection, of whichever pipeline."""

    group: str
    box: Edges
    boxes: Sequence[Edges]
    distance_m: float
    bearing: float


@dataclass(frozen=True)
class Score:
    """How well a pipeline did on all frames."""

    name: str
    frames: int
    named_car: float
    mean_iou: float
    mean_best_iou: float
    worst_distance_error_m: float


Pipeline = Callable[[int], Sequence[Answer]]
"""The detections in a frame."""


def iou(a: Edges, b: Edges) -> float:
    """Intersection over union of two boxes."""
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    shared = max(width, 0) * max(height, 0)
    return shared / ((a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - shared)


def read_truths(count: int) -> list[Truth]:
    """The first frames' truth; the bearing is that of the box's centre."""
    records = json.loads((DRIVE / "truth_0_29.json").read_text(encoding="utf-8"))[:count]
    K = read_geometry(DRIVE / "calibration.json").K
    return [
        Truth(
            record["frame"],
            record["box"],
            record["distance"],
            math.atan2(K[0, 2] - (record["box"][0] + record["box"][2]) / 2, K[0, 0]),
        )
        for record in records
    ]


def settings(defaults: Setting) -> list[Setting]:
    """The defaults, then all others."""
    others = [Setting(*each) for each in product_of((USUAL_HEIGHTS, HEIGHTS), RULES, FITS)]
    return [defaults, *(each for each in others if each != defaults)]


def product(recording: FolderRecording, classifier: Classifier, setting: Setting) -> Pipeline:
    """edgefusion, from the recording's files to its detections."""
    config = msgspec.structs.replace(DEFAULTS, objects=OBJECTS, heights=setting.heights, height_rule=setting.rule)
    detector = Detector(classifier, load_calibration(recording.calibration_path), config)
    return lambda index: [_answer(d) for d in detector.detect(recording.scan(index), recording.frame(index))]


def _answer(detection: Detection) -> Answer:
    return Answer(detection.group, detection.box, detection.boxes, detection.distance_m, detection.bearing)


def plain(recording: FolderRecording, groups: LabelGroups, resize: Resize) -> Pipeline:
    """The plain pipeline, its labels grouped as edgefusion's."""
    session = onnxruntime.InferenceSession(str(MODEL), providers=["CPUExecutionProvider"])
    labels = LABELS.read_text(encoding="utf-8").splitlines()
    geometry = read_geometry(DRIVE / "calibration.json")
    pipeline = PlainPipeline(network(session), labels, geometry, OBJECTS, resize)

    def detect(index: int) -> list[Answer]:
        scan, image = recording.scan(index), recording.frame(index).image[:, :, ::-1]
        found = pipeline.detect(scan.ranges_m.astype(float), scan.angles, image)
        return [_plain_answer(each, groups) for each in found]

    return detect


def by_opencv(crop: Pixels) -> Pixels:
    """OpenCV's default, which skips pixels where it shrinks a lot."""
    return np.asarray(cv2.resize(np.ascontiguousarray(crop), (SIZE, SIZE)), np.uint8)


def _plain_answer(found: Found, groups: LabelGroups) -> Answer:
    return Answer(groups.group_of(found.label), found.box, found.boxes, found.distance_m, found.bearing)


def evaluate(name: str, pipeline: Pipeline, truths: Sequence[Truth]) -> Score:
    """One pipeline on all frames; a frame without a detection counts as a miss with an IoU of 0."""
    named, ious, best, errors = [], [], [], []
    for truth in truths:
        ahead = car_ahead(pipeline(truth.frame), truth)
        named.append(ahead is not None and ahead.group == "car")
        ious.append(iou(ahead.box, truth.box) if ahead else 0.0)
        best.append(max(iou(box, truth.box) for box in ahead.boxes) if ahead else 0.0)
        errors.append(abs(ahead.distance_m - truth.distance_m) if ahead else math.inf)
    return Score(name, len(truths), float(np.mean(named)), float(np.mean(ious)), float(np.mean(best)), max(errors))


def car_ahead(answers: Sequence[Answer], truth: Truth) -> Answer | None:
    """The detection whose distance is nearest to the true one, then its bearing."""
    return min(
        answers,
        key=lambda answer: (abs(answer.distance_m - truth.distance_m), abs(answer.bearing - truth.bearing)),
        default=None,
    )


def scores(frames: int) -> Iterator[Score]:
    """Every candidate, the defaults first, the plain pipeline last."""
    truths, recording = read_truths(frames), FolderRecording(DRIVE)
    classifier = open_classifier(MODEL, labels=LABELS)
    defaults = Setting(USUAL_HEIGHTS, "paper", classifier.preprocessing.fit)
    for setting in settings(defaults):
        classifier.preprocessing = msgspec.structs.replace(classifier.preprocessing, fit=setting.fit)
        name = f"edgefusion, {setting}{' (the defaults)' if setting == defaults else ''}"
        yield evaluate(name, product(recording, classifier, setting), truths)
    groups = LabelGroups.load()
    yield evaluate("plain pipeline, Pillow's resize", plain(recording, groups, by_pillow), truths)
    yield evaluate("plain pipeline, OpenCV's resize", plain(recording, groups, by_opencv), truths)


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.kitti",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--frames", type=int, default=30, help="how many of the 30 (default: all)")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), metavar="DIR", help="default: out/bench")
    args = parser.parse_args(argv)
    if not (DRIVE.is_dir() and MODEL.is_file()):
        print("not measured: the real drive (../shared/data) is not on this machine", file=sys.stderr)
        return 0
    logging.disable(logging.WARNING)  # that nothing vouches for a bare model is known here
    found = []
    for score in scores(args.frames):
        print(f"{score.name}: IoU {score.mean_iou:.3f}", file=sys.stderr, flush=True)
        found.append(score)
    table = markdown(HEADER, [_cells(score) for score in found])
    print(table)
    print(f"written to {write_results(args.out, 'kitti', [asdict(s) for s in found], table)}", file=sys.stderr)
    return 0


HEADER = ("pipeline", "named car", "IoU", "best IoU", "worst distance error")


def _cells(score: Score) -> list[str]:
    return [
        score.name,
        f"{100 * score.named_car:.0f} % of {score.frames}",
        f"{score.mean_iou:.3f}",
        f"{score.mean_best_iou:.3f}",
        f"{1e3 * score.worst_distance_error_m:.0f} mm",
    ]


if __name__ == "__main__":
    sys.exit(main())
