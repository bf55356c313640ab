# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's pipeline as one would first write it: scikit-learn's DBSCAN, numpy, Pillow, ONNX Runtime.

The peer of whole frames and of `edgefusion detect`, which are given the same settings there. Run as a script
it writes the detections of a folder recording, line by line:

  python -m benchmarks.plain drive --model net.onnx --labels labels.txt --objects 8 --out detections.jsonl
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Sequence, Tuple

import numpy as np
import numpy.typing as npt
from PIL import Image
from sklearn.cluster import DBSCAN

Floats = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]
Box = Tuple[int, int, int, int]
Infer = Callable[[npt.NDArray[np.float32]], npt.NDArray[np.float32]]
"""A batch [n, 3, size, size] to probabilities [n, classes]."""

Resize = Callable[[Pixels], Pixels]
"""A crop of any size to 256 x 256."""

EPS_M, MIN_POINTS, MAX_WIDTH_M = 0.3, 3, 3.0
HEIGHTS = (0.6, 1.0, 1.6)
SIZE = 256
MEAN = np.array([0.485, 0.456, 0.406], np.float32)
STD = np.array([0.229, 0.224, 0.225], np.float32)


@dataclass(frozen=True)
class Geometry:
    """Camera matrix K [3, 3], laser to camera R [3, 3] and t [3], height of the laser above the ground."""

    K: Floats
    R: Floats
    t: Floats
    laser_height_m: float

    def project(self, points: Floats) -> Floats:
        """Pixels [n, 2] of points [n, 3] of the laser's frame; NaN behind the camera."""
        camera = points @ self.R.T + self.t
        depth = np.where(camera[:, 2:] > 0, camera[:, 2:], np.nan)
        return (camera / depth @ self.K.T)[:, :2]


@dataclass(frozen=True)
class Found:
    """One object: its label, the score, the winning box, all boxes and the nearest range."""

    class_index: int
    label: str
    score: float
    box: Box
    boxes: list[Box]
    distance_m: float
    bearing: float


class PlainPipeline:
    """Steps 2 to 9 of the paper, for the `objects` nearest clusters."""

    def __init__(
        self, infer: Infer, labels: Sequence[str], geometry: Geometry, objects: int, resize: Resize | None = None
    ) -> None:
        self._infer, self._labels, self._geometry, self._objects = infer, labels, geometry, objects
        self._resize = resize or by_pillow

    def detect(self, ranges_m: Floats, angles: Floats, image: Pixels) -> list[Found]:
        """The objects in a scan and an RGB image, nearest first."""
        hit = np.isfinite(ranges_m)
        ranges_m, angles = ranges_m[hit], angles[hit]
        clusters = self._clusters(ranges_m, angles, image.shape[1], image.shape[0])
        if not clusters:
            return []
        probabilities = self._infer(crop(image, [box for _, boxes in clusters for box in boxes], self._resize))
        found, first = [], 0
        for members, boxes in clusters:
            class_index, score, winner = vote(probabilities[first : first + len(boxes)])
            first += len(boxes)
            nearest = members[ranges_m[members].argmin()]
            distance_m, bearing = float(ranges_m[nearest]), float(angles[nearest])
            label = self._labels[class_index]
            found.append(Found(class_index, label, score, boxes[winner], boxes, distance_m, bearing))
        return found

    def _clusters(
        self, ranges_m: Floats, angles: Floats, width: int, height: int
    ) -> list[tuple[npt.NDArray[np.int64], list[Box]]]:
        """The nearest clusters that are no wall and project into the image, with their boxes."""
        points = np.column_stack([ranges_m * np.cos(angles), ranges_m * np.sin(angles)])
        if len(points) == 0:
            return []
        found = DBSCAN(eps=EPS_M, min_samples=MIN_POINTS).fit_predict(points)
        groups = [np.flatnonzero(found == label) for label in range(found.max() + 1)]
        groups.sort(key=lambda members: float(ranges_m[members].min()))
        clusters: list[tuple[npt.NDArray[np.int64], list[Box]]] = []
        for members in groups:
            if len(clusters) == self._objects:
                break
            if np.hypot(*np.ptp(points[members], axis=0)) > MAX_WIDTH_M:
                continue
            nearest = points[members[ranges_m[members].argmin()]]
            boxes = self._boxes(points[members], nearest, width, height)
            if boxes:
                clusters.append((members, boxes))
        return clusters

    def _boxes(self, points: Floats, nearest: Floats, width: int, height: int) -> list[Box]:
        """Boxes as wide as the cluster that stand on the ground, clipped; none where they are out of sight."""
        columns = self._geometry.project(np.column_stack([points, np.zeros(len(points))]))[:, 0]
        foot = np.append(nearest, -self._geometry.laser_height_m)
        bottom = self._geometry.project(foot[None])[0, 1]
        if np.isnan(columns).any() or np.isnan(bottom):
            return []
        left, right = columns.min(), columns.max()
        boxes: list[Box] = []
        for ratio in HEIGHTS:
            top = bottom - ratio * (right - left)
            x0, x1 = np.clip(np.round([left, right]), 0, width).astype(int)
            y0, y1 = np.clip(np.round([top, bottom]), 0, height).astype(int)
            if (x1 - x0) * (y1 - y0) >= 0.25 * (right - left) * (bottom - top) and x1 > x0 and y1 > y0:
                boxes.append((int(x0), int(y0), int(x1), int(y1)))
        return boxes


def crop(image: Pixels, boxes: Sequence[Box], resize: Resize) -> npt.NDArray[np.float32]:
    """Boxes of an RGB image, squashed to 256 x 256 and normalized: float32[n, 3, 256, 256]."""
    crops = []
    for x0, y0, x1, y1 in boxes:
        crop = resize(image[y0:y1, x0:x1])
        crops.append(((crop.astype(np.float32) / 255 - MEAN) / STD).transpose(2, 0, 1))
    return np.stack(crops)


def by_pillow(crop: Pixels) -> Pixels:
    """As torchvision resizes pictures of Pillow's."""
    return np.asarray(Image.fromarray(crop).resize((SIZE, SIZE), Image.Resampling.BILINEAR))


def vote(probabilities: npt.NDArray[np.float32], top_k: int = 5) -> tuple[int, float, int]:
    """The class with the best score, its score, and the box that proposed it with the highest probability."""
    scores: dict[int, float] = {}
    best: dict[int, tuple[float, int]] = {}
    for box, row in enumerate(probabilities):
        for class_index in np.argsort(row)[::-1][:top_k].tolist():
            probability = float(row[class_index])
            scores[class_index] = scores.get(class_index, 0.0) + probability / len(probabilities)
            best[class_index] = max(best.get(class_index, (0.0, 0)), (probability, box))
    winner = max(scores, key=lambda class_index: scores[class_index])
    return winner, scores[winner], best[winner][1]


def softmax(outputs: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Probabilities [n, classes] of a network's outputs [n, classes]."""
    powers = np.exp(outputs - outputs.max(axis=1, keepdims=True))
    return np.asarray(powers / powers.sum(axis=1, keepdims=True), np.float32)


def network(session: Any) -> Infer:
    """A classifier's session of ONNX Runtime as a function of a batch."""
    name = session.get_inputs()[0].name
    return lambda batch: softmax(session.run(None, {name: batch})[0].reshape(len(batch), -1))


def read_geometry(path: Path) -> Geometry:
    """The calibration of a folder recording."""
    content = json.loads(path.read_text(encoding="utf-8"))
    laser = content["laser_to_camera"]
    return Geometry(np.array(content["K"]), np.array(laser["R"]), np.array(laser["t"]), content["laser_height_m"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path, help="folder with images/, scans.npz and calibration.json")
    parser.add_argument("--model", type=Path, required=True, help="an .onnx classifier")
    parser.add_argument("--labels", type=Path, required=True, help="one label per line")
    parser.add_argument("--objects", type=int, default=8, help="the N nearest objects (default: 8)")
    parser.add_argument("--out", type=Path, required=True, help="file for the detections")
    args = parser.parse_args()

    import onnxruntime

    session = onnxruntime.InferenceSession(str(args.model), providers=["CPUExecutionProvider"])
    labels = args.labels.read_text(encoding="utf-8").splitlines()
    geometry = read_geometry(args.recording / "calibration.json")
    pipeline = PlainPipeline(network(session), labels, geometry, args.objects)
    scans = np.load(args.recording / "scans.npz")
    ranges_m = scans["ranges"].astype(float)
    angles = scans["angle_min"] + scans["angle_increment"] * np.arange(ranges_m.shape[1])
    with args.out.open("w", encoding="utf-8") as file:
        for index, path in enumerate(sorted((args.recording / "images").iterdir())):
            image = np.asarray(Image.open(path).convert("RGB"))
            for each in pipeline.detect(ranges_m[index], angles, image):
                print(json.dumps({"frame": index, **vars(each)}), file=file, flush=True)


if __name__ == "__main__":
    main()
