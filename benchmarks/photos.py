# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How well objects in annotated photographs are named and boxed, by fit, by the candidates' ratios, by height rule.

Stands in for the laser: left, right and bottom edge are those of the annotation (photo_boxes.json) with a seeded error
of up to 2 % of the width and 3 % of the height, three times per object; the top is what the candidates try. Crops,
network, vote and choice of the box are edgefusion's own, with a MobileNetV2.

IoU A: in the photograph, where the upper edge clips the tall candidates and so gives a height away that a robot would
not know. IoU B: in the photograph continued upwards until no candidate is clipped there. label: how often the vote in A
names the object's class; group: or another class of its group (a class without a group is a group of its own). With
95 % intervals from resampling the objects; differences are between the same objects. A measurement on few objects:
nothing is tuned here, and the annotations, which are off by a few percent, limit the IoU.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Sequence, Tuple

import cv2
import msgspec
import numpy as np
import numpy.typing as npt
from benchmarks.kitti import iou
from benchmarks.run import markdown, write_results
from tqdm import tqdm

from edgefusion.config import PerceptionConfig
from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.groups import LabelGroups
from edgefusion.perception.height_rule import HEIGHT_RULES, choose_box
from edgefusion.perception.network import RuntimeOptions
from edgefusion.perception.voting import vote
from edgefusion.types import Box

EXAMPLES = """examples:
  python -m benchmarks.photos
  python -m benchmarks.photos --out out/photos --threads 0"""

SHARED = Path(__file__).resolve().parents[2] / "shared" / "data"
IMAGES = SHARED / "images"
MODEL = SHARED / "models" / "mobilenetv2_fp32_dequant.onnx"
LABELS = SHARED / "models" / "imagenet_classes.txt"
BOXES = Path(__file__).with_name("photo_boxes.json")

FITS = ("squash", "letterbox", "square-context")
PAPER_LIKE, WIDE, FIVE = (0.6, 1.0, 1.6), (0.4, 1.0, 2.5), (0.4, 0.63, 1.0, 1.6, 2.5)
RATIOS = (PAPER_LIKE, WIDE, FIVE)
TRIED = tuple(sorted({ratio for each in RATIOS for ratio in each}))

DRAWS, SEED, RESAMPLES = 3, 7, 4000
SIDE_ERROR, BOTTOM_ERROR = 0.02, 0.03  # of the object's width and height
MIN_VISIBLE = PerceptionConfig().min_visible

Floats = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]
Edges = Tuple[float, float, float, float]
Guesses = Dict[float, Tuple[Box, npt.NDArray[np.float32]]]
"""Of every ratio that is visible: its box and the classifier's answer for that."""


@dataclass(frozen=True)
class Subject:
    """An annotated object; border: what surrounds a photograph that it fills, "" for none."""

    image: str
    label: str
    box: Edges
    border: str = ""


@dataclass(frozen=True)
class Picture:
    """Pixels, and where the object is in them."""

    pixels: Pixels
    box: Edges


class Setup(NamedTuple):
    """What is compared."""

    fit: str
    ratios: tuple[float, ...]
    rule: str


class Score(NamedTuple):
    """What one object got: means over the draws."""

    iou_clipped: float
    iou_extended: float
    label: float
    group: float


SETUPS = [Setup(*each) for each in product(FITS, RATIOS, HEIGHT_RULES)]
DIFFERENCES = [
    *((Setup("letterbox", *rest), Setup("squash", *rest)) for rest in product(RATIOS, HEIGHT_RULES)),
    *((Setup(fit, WIDE, rule), Setup(fit, PAPER_LIKE, rule)) for fit, rule in product(FITS, HEIGHT_RULES)),
]


def read_subjects(path: Path = BOXES) -> list[Subject]:
    """The annotations."""
    records = json.loads(path.read_text(encoding="utf-8"))["objects"]
    return [Subject(each["image"], each["label"], tuple(each["box"]), each.get("border", "")) for each in records]


def read_picture(subject: Subject) -> Picture:
    """The photograph of an object, with its border."""
    pixels = np.asarray(cv2.imread(str(IMAGES / subject.image)), np.uint8)
    return surrounded(Picture(pixels, subject.box), subject.border) if subject.border else Picture(pixels, subject.box)


def surrounded(picture: Picture, border: str) -> Picture:
    """Room above, below and beside: white, or the edge pixels repeated."""
    height, width = picture.pixels.shape[:2]
    above, below, beside = int(0.6 * height), int(0.15 * height), int(0.25 * width)
    kind = cv2.BORDER_CONSTANT if border == "white" else cv2.BORDER_REPLICATE
    pixels = cv2.copyMakeBorder(picture.pixels, above, below, beside, beside, kind, value=(255, 255, 255))
    return Picture(np.asarray(pixels, np.uint8), moved(picture.box, beside, above))


def extended(picture: Picture, ratio: float) -> Picture:
    """The picture continued upwards by its blurred upper rows, so that no candidate up to a ratio is clipped there."""
    x0, y0, x1, y1 = picture.box
    tallest = ratio * (1 + 2 * SIDE_ERROR) * (x1 - x0) + BOTTOM_ERROR * (y1 - y0)
    missing = math.ceil(tallest - y1) + 1
    if missing <= 0:
        return picture
    height, width = picture.pixels.shape[:2]
    row = picture.pixels[: max(3, height // 40)].mean(axis=0, keepdims=True)
    blurred = np.asarray(cv2.GaussianBlur(row, (0, 0), max(2.0, width / 40))).reshape(row.shape)
    above = np.repeat(np.rint(blurred).astype(np.uint8), missing, axis=0)
    return Picture(np.concatenate([above, picture.pixels]), moved(picture.box, 0, missing))


def moved(box: Edges, right: int, down: int) -> Edges:
    x0, y0, x1, y1 = box
    return x0 + right, y0 + down, x1 + right, y1 + down


def seen(box: Edges, errors: Sequence[float]) -> tuple[float, float, float]:
    """Left, right and bottom edge as a laser would have them. errors: of each, -1..1."""
    x0, y0, x1, y1 = box
    side, up = SIDE_ERROR * (x1 - x0), BOTTOM_ERROR * (y1 - y0)
    return x0 + errors[0] * side, x1 + errors[1] * side, y1 + errors[2] * up


def candidate(left: float, right: float, bottom: float, ratio: float, width: int, height: int) -> Box | None:
    """The candidate of a ratio, clipped to the image as edgefusion does it; None where too little is visible."""
    top = bottom - ratio * (right - left)
    x0, y0, x1, y1 = max(left, 0.0), max(top, 0.0), min(right, float(width)), min(bottom, float(height))
    visible = max(x1 - x0, 0.0) * max(y1 - y0, 0.0)
    if visible <= 0 or visible < MIN_VISIBLE * (right - left) * (bottom - top):
        return None
    x0, y0 = min(nearest(x0), width - 1), min(nearest(y0), height - 1)
    return x0, y0, max(nearest(x1), x0 + 1), max(nearest(y1), y0 + 1)


def nearest(pixel: float) -> int:
    """Rounded half up, as C++ does where Python rounds half to even."""
    return math.floor(pixel + 0.5)


def classify(classifier: Classifier, picture: Picture, errors: Sequence[float]) -> Guesses:
    """All candidates in one batch."""
    height, width = picture.pixels.shape[:2]
    edges = seen(picture.box, errors)
    boxes = {ratio: candidate(*edges, ratio, width, height) for ratio in TRIED}
    visible = {ratio: box for ratio, box in boxes.items() if box}
    rows = classifier.probabilities(picture.pixels, list(visible.values()))
    return {ratio: (box, row) for (ratio, box), row in zip(visible.items(), rows)}


def answer(guesses: Guesses, ratios: Sequence[float], rule: str, labels: Sequence[str]) -> tuple[str, Box]:
    """The label and the box that edgefusion gives an object of which these candidates are visible."""
    boxes, rows = zip(*(guesses[ratio] for ratio in ratios if ratio in guesses))
    probabilities = np.stack(rows)
    ballot = vote(probabilities, labels)
    assert ballot is not None  # only a network whose numbers are not finite gives none
    return ballot.winner.label, choose_box(rule, ballot, boxes, probabilities)


class Scorer:
    """Scores objects with one classifier, whose fit it changes."""

    def __init__(self, classifier: Classifier) -> None:
        self._classifier, self._groups = classifier, LabelGroups.load()

    def scores(self, subject: Subject, errors: Floats) -> Iterator[tuple[Setup, Score]]:
        """Every setup's on one object. errors: float64[draws, 3]."""
        picture = read_picture(subject)
        pictures = (picture, extended(picture, max(TRIED)))
        for fit in FITS:
            guesses = [[self._guesses(fit, each, draw) for each in pictures] for draw in errors.tolist()]
            for ratios, rule in product(RATIOS, HEIGHT_RULES):
                scores = [self._score(subject, pictures, each, ratios, rule) for each in guesses]
                yield Setup(fit, ratios, rule), Score(*np.mean(scores, axis=0).tolist())

    def _guesses(self, fit: str, picture: Picture, draw: Sequence[float]) -> Guesses:
        changed = msgspec.structs.replace(self._classifier.preprocessing, fit=fit)
        self._classifier.preprocessing = changed
        return classify(self._classifier, picture, draw)

    def _score(
        self,
        subject: Subject,
        pictures: Sequence[Picture],
        guesses: Sequence[Guesses],
        ratios: Sequence[float],
        rule: str,
    ) -> Score:
        answers = [answer(each, ratios, rule, self._classifier.labels) for each in guesses]
        clipped, continued = (iou(box, picture.box) for (_, box), picture in zip(answers, pictures))
        label = answers[0][0]
        same_group = self._group(label) == self._group(subject.label)
        return Score(clipped, continued, float(label == subject.label), float(same_group))

    def _group(self, label: str) -> str:
        return self._groups.group_of(label) or label


def measure(subjects: Sequence[Subject], classifier: Classifier) -> dict[Setup, Floats]:
    """float64[objects, 4] for every setup: a Score per object."""
    errors = np.random.default_rng(SEED).uniform(-1, 1, (len(subjects), DRAWS, 3))
    scorer = Scorer(classifier)
    found: Dict[Setup, List[Score]] = {setup: [] for setup in SETUPS}
    for subject, draws in zip(tqdm(subjects, unit="object", file=sys.stderr), errors):
        for setup, score in scorer.scores(subject, draws):
            found[setup].append(score)
    return {setup: np.array(scores) for setup, scores in found.items()}


def interval(values: Floats) -> dict[str, list[float]]:
    """Mean and 95 % interval of each column of float64[objects, 4], over objects drawn anew with replacement."""
    chosen = np.random.default_rng(SEED).integers(0, len(values), (RESAMPLES, len(values)))
    low, high = np.quantile(values[chosen].mean(axis=1), [0.025, 0.975], axis=0)
    columns = np.stack([values.mean(axis=0), low, high], axis=1)
    return dict(zip(Score._fields, columns.tolist()))


def records_of(found: Mapping[Setup, Floats]) -> list[dict[str, Any]]:
    """Every setup, then the differences; a setup that is compared with another has it as `minus`."""
    setups = [{**setup._asdict(), **interval(values)} for setup, values in found.items()]
    differences = [
        {**setup._asdict(), "minus": other._asdict(), **interval(found[setup] - found[other])}
        for setup, other in DIFFERENCES
    ]
    return setups + differences


HEADER = ("fit", "ratios", "rule", "IoU A", "IoU B", "label", "group")


def _cells(record: Mapping[str, Any]) -> list[str]:
    other = record.get("minus", record)
    names = ((_text(record[name]), _text(other[name])) for name in ("fit", "ratios", "rule"))
    number = "+.3f" if "minus" in record else ".3f"
    return [
        *(mine if mine == its else f"{mine} minus {its}" for mine, its in names),
        *("{} [{}, {}]".format(*(format(value, number) for value in record[name])) for name in Score._fields),
    ]


def _text(value: object) -> str:
    return " ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.photos",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--threads", type=int, default=1, help="of the network; 0: one per core (default: 1)")
    parser.add_argument("--out", type=Path, default=Path("out/photos"), metavar="DIR", help="default: out/photos")
    args = parser.parse_args(argv)
    subjects = read_subjects()
    if not all(path.is_file() for path in (MODEL, LABELS, *(IMAGES / each.image for each in subjects))):
        print("not measured: the photographs or the model (../shared/data) are not on this machine", file=sys.stderr)
        return 0
    logging.disable(logging.WARNING)  # that nothing vouches for a bare model is known here
    found = measure(subjects, open_classifier(MODEL, LABELS, RuntimeOptions(threads=args.threads)))
    records = records_of(found)
    table = markdown(HEADER, [_cells(record) for record in records])
    print(f"{len(subjects)} objects\n\n{table}")
    print(f"written to {write_results(args.out, 'photos', records, table)}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
