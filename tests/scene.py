# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A small scene of known truth: a room with a few plain solids, as a folder recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.recording.folder import SCANS
from edgefusion.types import Frame, Scan

Floats = npt.NDArray[np.float64]

WIDTH, HEIGHT, FOCAL_PX = 640, 480, 460.0
LASER_HEIGHT_M = 0.25
CAMERA_ABOVE_LASER_M = 0.20
NEAR_M = 0.05
FRAMES, FRAME_NS, STEP_M = 6, 200_000_000, 0.08
RANGE_SIGMA_M = 0.01

K = np.array([[FOCAL_PX, 0, (WIDTH - 1) / 2], [0, FOCAL_PX, (HEIGHT - 1) / 2], [0, 0, 1]])
# Laser axes (x forward, y left, z up) into camera axes (z forward, x right, y down).
T_CAMERA_LASER = np.array([[0, -1, 0, 0], [0, 0, -1, CAMERA_ABOVE_LASER_M], [1, 0, 0, 0], [0, 0, 0, 1]], float)


@dataclass(frozen=True)
class Solid:
    """An upright prism on the floor: its outline [n, 2] counter-clockwise, its height [m], its colour (BGR)."""

    name: str
    outline: Floats
    height_m: float
    color: tuple[int, int, int]


def box(name: str, x: float, y: float, depth: float, width: float, height: float, yaw: float, color: int) -> Solid:
    """A box about (x, y), turned by yaw [rad], colour 0xRRGGBB."""
    corners = np.array([[1, -1], [1, 1], [-1, 1], [-1, -1]]) * (depth / 2, width / 2)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    return Solid(name, corners @ turn.T + (x, y), height, _bgr(color))


def drum(name: str, x: float, y: float, radius: float, height: float, color: int) -> Solid:
    """A cylinder about (x, y)."""
    angles = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    outline = np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)
    return Solid(name, outline, height, _bgr(color))


def _bgr(color: int) -> tuple[int, int, int]:
    return color & 255, color >> 8 & 255, color >> 16 & 255


WALL = 0xD8D2C4
ROOM = (
    box("wall", 5.2, 0.0, 0.2, 7.0, 2.4, 0.0, WALL),
    box("wall", 2.0, 3.0, 6.4, 0.2, 2.4, 0.0, WALL),
    box("wall", 2.0, -3.0, 6.4, 0.2, 2.4, 0.0, WALL),
)
OBJECTS = (
    box("crate", 2.3, 0.75, 0.40, 0.55, 0.50, 0.45, 0xC8883A),
    drum("drum", 2.9, -0.70, 0.24, 0.75, 0x3A78B8),
    box("cabinet", 3.9, 0.35, 0.45, 0.60, 1.30, -0.2, 0x7A9E6E),
    drum("post", 1.7, -0.22, 0.05, 0.95, 0xB84A4A),
)


def nearest_m(solid: Solid, robot_x: float) -> float:
    """True distance from the laser's origin to the solid's nearest surface [m]."""
    a = solid.outline - (robot_x, 0.0)
    edge = np.roll(a, -1, axis=0) - a
    along = np.clip(-(a * edge).sum(axis=1) / (edge * edge).sum(axis=1), 0, 1)
    return float(np.hypot(*(a + along[:, None] * edge).T).min())


def cast_scan(robot_x: float, stamp_ns: int, rng: np.random.Generator) -> Scan:
    """361 beams over 180 degrees from (robot_x, 0), with range noise."""
    angles = np.radians(np.linspace(-90, 90, 361))
    beam = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    nearest = np.full(len(angles), np.inf)
    for solid in ROOM + OBJECTS:
        a = solid.outline - (robot_x, 0.0)
        for start, edge in zip(a, np.roll(a, -1, axis=0) - a):
            nearest = np.fmin(nearest, _hit(beam, start, edge))
    ranges_m = nearest + rng.normal(0, RANGE_SIGMA_M, len(nearest))
    return Scan(stamp_ns, ranges_m.astype(np.float32), -np.pi / 2, np.radians(0.5))


def _hit(beam: Floats, start: Floats, edge: Floats) -> Floats:
    """Range of every beam [n, 2] to one edge of an outline; NaN where it misses."""
    across = beam[:, 0] * edge[1] - beam[:, 1] * edge[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        range_m = (start[0] * edge[1] - start[1] * edge[0]) / across
        share = (start[0] * beam[:, 1] - start[1] * beam[:, 0]) / across
    return np.where((range_m > 0) & (share >= 0) & (share <= 1), range_m, np.nan)


def paint_frame(robot_x: float, stamp_ns: int, rng: np.random.Generator) -> Frame:
    """The camera's picture of the scene: every face that looks at the camera, the farthest first."""
    image = np.full((HEIGHT, WIDTH, 3), (96, 100, 104), np.uint8)  # the floor
    image[: HEIGHT // 2] = (228, 226, 222)
    faces = [face for solid in ROOM + OBJECTS for face in _faces(solid, robot_x)]
    for _, polygon, color in sorted(faces, key=lambda face: -face[0]):
        cv2.fillPoly(image, [polygon], color, cv2.LINE_AA, shift=4)
    noisy = image + rng.normal(0, 3.0, image.shape)
    return Frame(stamp_ns, np.clip(noisy, 0, 255).astype(np.uint8))


def _faces(solid: Solid, robot_x: float) -> list[tuple[float, npt.NDArray[np.int32], tuple[int, int, int]]]:
    """Sides and top as (distance, polygon in 1/16 pixel, colour)."""
    floor = np.pad(solid.outline - (robot_x, 0.0), ((0, 0), (0, 1)), constant_values=-LASER_HEIGHT_M)
    top = floor + np.array([0, 0, solid.height_m])
    faces = [(top, 1.0)] if solid.height_m < LASER_HEIGHT_M + CAMERA_ABOVE_LASER_M else []
    for i in range(len(floor)):
        j = (i + 1) % len(floor)
        normal = np.array([floor[j, 1] - floor[i, 1], floor[i, 0] - floor[j, 0]])
        if normal @ floor[i, :2] < 0:  # looks at the camera
            shade = 0.62 + 0.30 * abs(normal[0]) / np.hypot(*normal)
            faces.append((np.array([floor[i], floor[j], top[j], top[i]]), shade))
    seen = [(corners, shade, _in_front(corners)) for corners, shade in faces]
    return [
        (float(np.hypot(*corners[:, :2].mean(axis=0))), _pixels(front), _shaded(solid.color, shade))
        for corners, shade, front in seen
        if len(front) >= 3
    ]


def _in_front(corners: Floats) -> Floats:
    """The part of a polygon [n, 3] of the laser's frame that is in front of the camera, in camera coordinates."""
    points = corners @ T_CAMERA_LASER[:3, :3].T + T_CAMERA_LASER[:3, 3]
    kept = []
    for a, b in zip(points, np.roll(points, -1, axis=0)):
        if a[2] >= NEAR_M:
            kept.append(a)
        if (a[2] >= NEAR_M) != (b[2] >= NEAR_M):
            kept.append(a + (NEAR_M - a[2]) / (b[2] - a[2]) * (b - a))
    return np.array(kept).reshape(-1, 3)


def _pixels(points: Floats) -> npt.NDArray[np.int32]:
    pixels = (points / points[:, 2:]) @ K.T
    fixed_point: npt.NDArray[np.int32] = np.round(np.clip(pixels[:, :2], -20000, 20000) * 16).astype(np.int32)
    return fixed_point.reshape(-1, 1, 2)


def _shaded(color: tuple[int, int, int], shade: float) -> tuple[int, int, int]:
    b, g, r = (round(channel * shade) for channel in color)
    return b, g, r


def write_recording(folder: Path, seed: int = 0) -> Path:
    """The robot drives towards the objects: a folder recording. Returns the folder."""
    rng = np.random.default_rng(seed)
    (folder / "images").mkdir(parents=True, exist_ok=True)
    stamps_ns = [i * FRAME_NS for i in range(FRAMES)]
    scans = [cast_scan(i * STEP_M, stamp, rng) for i, stamp in enumerate(stamps_ns)]
    for i, stamp in enumerate(stamps_ns):
        _, data = cv2.imencode(".jpg", paint_frame(i * STEP_M, stamp, rng).image)
        (folder / "images" / f"{i:06d}.jpg").write_bytes(data.tobytes())
    np.savez_compressed(
        folder / SCANS,
        stamp=np.array(stamps_ns) / 1e9,
        ranges=np.stack([scan.ranges_m for scan in scans]),
        angle_min=scans[0].angle_min,
        angle_increment=scans[0].angle_increment,
    )
    (folder / "calibration.toml").write_text(_calibration_toml(), encoding="utf-8")
    return folder


def _calibration_toml() -> str:
    return (
        f"version = 1\nimage_size = [{WIDTH}, {HEIGHT}]\nK = {K.tolist()}\ndistortion = []\n"
        f"T_camera_laser = {T_CAMERA_LASER.tolist()}\nlaser_height_m = {LASER_HEIGHT_M}\n"
    )
