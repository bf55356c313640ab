# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion detect` as a user starts it: time to the first detection, total time and peak memory.

Against the plain pipeline as a script (plain.py), both as child processes on the beginning of a real drive with a
MobileNetV2 and the 8 nearest objects; where that is absent, on the scene of the tests with a ResNet18 of
random weights. The first detection is there when its line is in the file of results.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Mapping, Sequence

import numpy as np
from benchmarks.plain import HEIGHTS
from benchmarks.timing import Row

SHARED = Path(__file__).resolve().parents[2] / "shared" / "data"
DRIVE, MODELS = SHARED / "kitti-drive", SHARED / "models"
POLL_S = 0.002


@dataclass(frozen=True)
class MemoryRow(Row):
    """Megabytes in the place of seconds."""

    unit: str = "MB"


@dataclass(frozen=True)
class Job:
    """What both candidates are given."""

    recording: Path
    model: Path
    labels: Path

    def arguments(self) -> list[str]:
        return [str(self.recording), "--model", str(self.model), "--labels", str(self.labels), "--objects", "8"]


@dataclass(frozen=True)
class Measured:
    """One run of a child process."""

    first_s: float
    total_s: float
    peak_mb: float


def beginning_of_drive(folder: Path, frames: int) -> Path:
    """A recording of the drive's first frames, its images linked."""
    (folder / "images").mkdir(parents=True)
    for image in sorted((DRIVE / "images").iterdir())[:frames]:
        (folder / "images" / image.name).symlink_to(image)
    (folder / "calibration.json").symlink_to(DRIVE / "calibration.json")
    with np.load(DRIVE / "scans.npz") as drive:
        beams = {name: drive[name][:frames] for name in ("stamp", "ranges")}
        np.savez(
            folder / "scans.npz",
            **beams,
            angle_min=drive["angle_min"],
            angle_increment=drive["angle_increment"],
        )
    return folder


def built_in_scene(folder: Path) -> Path:
    """The scene of the tests, with the calibration in both files' formats."""
    from tests import scene

    scene.write_recording(folder)
    extrinsic = {"R": scene.T_CAMERA_LASER[:3, :3].tolist(), "t": scene.T_CAMERA_LASER[:3, 3].tolist()}
    calibration = {
        "image_size": [scene.WIDTH, scene.HEIGHT],
        "K": scene.K.tolist(),
        "laser_to_camera": extrinsic,
        "laser_height_m": scene.LASER_HEIGHT_M,
    }
    (folder / "calibration.json").write_text(json.dumps(calibration), encoding="utf-8")
    return folder


def random_model(folder: Path) -> tuple[Path, Path]:
    """A ResNet18 of random weights and its labels."""
    from benchmarks.darknet import build_network, resnet18_cfg

    model, labels = folder / "resnet18.onnx", folder / "labels.txt"
    model.write_bytes(build_network(resnet18_cfg(256)).SerializeToString())
    labels.write_text("".join(f"class {index}\n" for index in range(1000)), encoding="utf-8")
    return model, labels


def prepare(folder: Path, frames: int) -> tuple[Job, str]:
    """The job, and its name for the table."""
    if DRIVE.is_dir() and MODELS.is_dir():
        recording = beginning_of_drive(folder / "drive", frames)
        model, labels = MODELS / "mobilenetv2_fp32_dequant.onnx", MODELS / "imagenet_classes.txt"
        return Job(recording, model, labels), f"{frames} frames of a real drive, MobileNetV2"
    return Job(built_in_scene(folder / "scene"), *random_model(folder)), "built-in scene, ResNet18"


def commands(job: Job, out: Path) -> dict[str, tuple[list[str], Path]]:
    """The command of each candidate, and the file that its detections go into."""
    results = out / "product"
    lines = out / "plain.jsonl"
    config = out / "config.toml"
    config.write_text(f"version = 1\n[perception]\nheights = {list(HEIGHTS)}\n", encoding="utf-8")
    given = job.arguments()
    product = [sys.executable, "-m", "edgefusion.cli", "detect", *given, "--config", str(config), "--overwrite"]
    plain = [sys.executable, "-m", "benchmarks.plain", *given]
    return {
        "product": ([*product, "--out", str(results)], results / "detections.jsonl"),
        "plain": ([*plain, "--out", str(lines)], lines),
    }


def measure(command: Sequence[str], lines: Path) -> Measured:
    """Runs a command to its end. Raises RuntimeError where it fails or finds nothing."""
    lines.unlink(missing_ok=True)
    first_s, peak_mb = None, 0.0
    with tempfile.TemporaryFile() as said:
        start = time.perf_counter()
        child = subprocess.Popen(command, stdout=said, stderr=said, cwd=Path(__file__).resolve().parents[1])
        try:
            while child.poll() is None:
                if first_s is None and lines.exists() and lines.stat().st_size > 0:
                    first_s = time.perf_counter() - start
                peak_mb = max(peak_mb, peak_memory_mb(child.pid))
                time.sleep(POLL_S)
        finally:
            child.kill()
        total_s = time.perf_counter() - start
        said.seek(0)
        last = said.read().decode(errors="replace").strip().splitlines()[-1:]
    if child.returncode != 0 or first_s is None:
        raise RuntimeError(f"{' '.join(command[1:4])}: exit code {child.returncode}: {last}")
    return Measured(first_s, total_s, peak_mb)


def peak_memory_mb(pid: int) -> float:
    """The most memory a process has had resident so far; its own, unlike rusage's, which starts at its parent's."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    except OSError:  # it has just ended
        return 0.0
    peaks = [int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM:")]
    return peaks[0] / 1024 if peaks else 0.0


def medians(runs: Mapping[str, Sequence[Measured]], quantity: str) -> tuple[float, float]:
    """The medians of the product and of the plain script."""
    product, plain = (statistics.median(getattr(run, quantity) for run in runs[name]) for name in ("product", "plain"))
    return product, plain


def rows(rounds: int = 3, frames: int = 20) -> list[Row]:
    """The rows of the common table: the candidates take turns."""
    runs: dict[str, list[Measured]] = {"product": [], "plain": []}
    with tempfile.TemporaryDirectory() as temporary:
        job, name = prepare(Path(temporary), frames)
        for _ in range(rounds):
            for candidate, (command, lines) in commands(job, Path(temporary)).items():
                runs[candidate].append(measure(command, lines))
    table: list[Row] = []
    for kind, what, quantity in (
        (Row, "time to the first detection", "first_s"),
        (Row, "total time", "total_s"),
        (MemoryRow, "peak memory", "peak_mb"),
    ):
        product, plain = medians(runs, quantity)
        table.append(kind(f"detect, {name}: {what}", product, "plain script", plain, plain / product, None))
    return table
