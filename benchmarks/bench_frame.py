# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One frame of the paper's job: the nearest object, three boxes, one name.

First all but the network, against the same job by scikit-learn, numpy and Pillow (plain.py) and against 1 ms.
Then whole frames with a ResNet18 of random weights, against the plain pipeline and against YOLOv3 and Tiny-YOLOv2 in
the same runtime with the same settings. Of the YOLO networks only the run itself is timed, not the resizing of the
image nor the decoding of boxes, which favours them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any, Callable, Mapping

import numpy as np
import numpy.typing as npt
from benchmarks.darknet import build_network, load_network, resnet18_cfg
from benchmarks.plain import HEIGHTS, Geometry, Infer, PlainPipeline, network
from benchmarks.timing import Row, interleaved

from edgefusion.config import PerceptionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.classifier import Classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.network import RuntimeOptions
from edgefusion.perception.preprocessing import PAPER
from edgefusion.types import Frame, Scan

YOLO_CFG = Path(__file__).resolve().parents[2] / "shared" / "data" / "yolo-cfg"
PAPERS_RATIOS = {"YOLOv3": ("yolov3.cfg", 6.2 / 2.7), "Tiny-YOLOv2": ("yolov2-tiny.cfg", 6.2 / 17.1)}
"""The paper's frames per second on the TX2, its own to each peer's."""

LABELS = [f"class {index}" for index in range(1000)]
T_CAMERA_LASER = np.array([[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]], float)
LASER_HEIGHT_M = 0.25
ANGLES = np.radians(np.linspace(-90, 90, 361))


@dataclass(frozen=True)
class FrameRow(Row):
    """Seconds per frame; the table also says how many frames a second that is."""

    unit: str = "frame"


class InstantClassifier(Classifier):
    """Real crops, and an answer that takes no time."""

    def __init__(self) -> None:
        pooled = f"{resnet18_cfg(PAPER.size).split('[convolutional]')[0]}\n[avgpool]\n[convolutional]\nfilters=1000"
        super().__init__(build_network(pooled).SerializeToString(), "pooled", LABELS, PAPER)
        self.answer = np.random.default_rng(0).dirichlet(np.full(1000, 0.05), 3).astype(np.float32)

    def infer(self, batch: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        return self.answer[: len(batch)]


def make_scan(random: np.random.Generator) -> Scan:
    """A face of 0.5 m, 2 m ahead in a room 6 m deep and 8 m wide, with the noise of a SICK LMS."""
    with np.errstate(divide="ignore"):
        ranges_m = np.minimum(6 / np.abs(np.cos(ANGLES)), 4 / np.abs(np.sin(ANGLES)))
    face = np.abs(2 * np.tan(ANGLES)) < 0.25
    ranges_m[face] = 2 / np.cos(ANGLES[face])
    noisy = ranges_m + random.normal(0, 0.01, len(ranges_m))
    return Scan(0, noisy.astype(np.float32), ANGLES[0], np.radians(0.5))


def make_frame(width: int, height: int) -> Frame:
    return Frame(0, np.random.default_rng(0).integers(0, 256, (height, width, 3), dtype=np.uint8))


def camera_matrix(width: int, height: int) -> npt.NDArray[np.float64]:
    """A lens of 70 degrees."""
    focal_px = width / 1.4
    return np.array([[focal_px, 0, (width - 1) / 2], [0, focal_px, (height - 1) / 2], [0, 0, 1]])


def product(classifier: Classifier, frame: Frame, scans: list[Scan]) -> Callable[[], object]:
    """edgefusion on one scan after another: on a single one, repeated, the processor would learn every branch."""
    height, width = frame.image.shape[:2]
    T_base_laser = np.eye(4)
    T_base_laser[2, 3] = LASER_HEIGHT_M
    calibration = Calibration(
        (width, height), camera_matrix(width, height), (), T_CAMERA_LASER, T_base_laser, LASER_HEIGHT_M
    )
    detector = Detector(classifier, calibration, PerceptionConfig(objects=1, heights=HEIGHTS))
    if len(detector.detect(scans[0], frame)[0].boxes) != 3:
        raise RuntimeError("the scene is meant to give three boxes")
    turn = cycle(scans)
    return lambda: detector.detect(next(turn), frame)


def plain(infer: Infer, frame: Frame, scans: list[Scan]) -> Callable[[], object]:
    """The plain pipeline on the same scans; their angles and the image in RGB are given, which favours it."""
    height, width = frame.image.shape[:2]
    geometry = Geometry(camera_matrix(width, height), T_CAMERA_LASER[:3, :3], T_CAMERA_LASER[:3, 3], LASER_HEIGHT_M)
    pipeline = PlainPipeline(infer, LABELS, geometry, objects=1)
    rgb = np.ascontiguousarray(frame.image[:, :, ::-1])
    if len(pipeline.detect(scans[0].ranges_m.astype(float), ANGLES, rgb)[0].boxes) != 3:
        raise RuntimeError("the scene is meant to give three boxes")
    turn = cycle(scan.ranges_m.astype(float) for scan in scans)
    return lambda: pipeline.detect(next(turn), ANGLES, rgb)


def rows_without_inference(scans: list[Scan], rounds: int) -> list[Row]:
    classifier = InstantClassifier()
    table = []
    for width, height in ((1280, 720), (2592, 1944)):
        frame = make_frame(width, height)
        median = interleaved(
            {
                "product": product(classifier, frame, scans),
                "plain": plain(lambda batch: classifier.answer[: len(batch)], frame, scans),
            },
            rounds,
        )
        name = f"frame without inference, 3 boxes of {width} x {height}"
        product_s = median["product"]
        if width == 1280:
            table.append(Row(name, product_s, "a limit of 1 ms", 1e-3, 1e-3 / product_s, 1))
        table.append(Row(name, product_s, "plain pipeline", median["plain"], median["plain"] / product_s, None))
    return table


def make_session(model: bytes, threads: int) -> Any:
    """A session with edgefusion's settings. Idle threads that spin would slow the candidate whose turn is next."""
    import onnxruntime

    settings = onnxruntime.SessionOptions()
    settings.intra_op_num_threads = threads
    settings.add_session_config_entry("session.intra_op.allow_spinning", "0")
    return onnxruntime.InferenceSession(model, settings, providers=["CPUExecutionProvider"])


def yolo(cfg: Path, threads: int) -> Callable[[], object]:
    """One run of a detector of random weights at 416 x 416."""
    session = make_session(load_network(cfg, side=416).SerializeToString(), threads)
    image = np.random.default_rng(0).random((1, 3, 416, 416), np.float32)
    return lambda: session.run(None, {"image": image})


def rows_whole(scans: list[Scan], threads: int, rounds: int) -> list[Row]:
    model = build_network(resnet18_cfg(PAPER.size)).SerializeToString()
    options = RuntimeOptions(provider="cpu", threads=threads)
    frame = make_frame(1280, 720)
    candidates = {
        "product": product(Classifier(model, "ResNet18", LABELS, PAPER, options=options), frame, scans),
        "plain pipeline": plain(network(make_session(model, threads)), frame, scans),
    }
    for peer, (cfg, _) in PAPERS_RATIOS.items():
        if (YOLO_CFG / cfg).is_file():
            candidates[peer] = yolo(YOLO_CFG / cfg, threads)
    median = interleaved(candidates, rounds)
    name = f"whole frame, ResNet18, 3 boxes, {threads} thread{'s' * (threads > 1)}"
    aims = {"plain pipeline": None, **{peer: aim for peer, (_, aim) in PAPERS_RATIOS.items()}}
    return [compared(name, median, peer, aim) for peer, aim in aims.items()]


def compared(name: str, median: Mapping[str, float], peer: str, aim: float | None) -> Row:
    """A row; one without numbers where the peer's layer list is absent."""
    peer_s, said = median.get(peer, math.nan), "" if peer in median else " (not measured: ../shared/data is absent)"
    return FrameRow(name, median["product"], f"{peer}{said}", peer_s, peer_s / median["product"], aim)


def rows(rounds: int = 15) -> list[Row]:
    """The rows of the common table."""
    random = np.random.default_rng(0)
    scans = [make_scan(random) for _ in range(20)]
    table = rows_without_inference(scans, 4 * rounds)
    for threads in (1, 2):
        table += rows_whole(scans, threads, rounds)
    return table
