# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures of what the detector sees: boxes over the image, clusters over the scan. BGR uint8."""

from __future__ import annotations

from typing import Sequence, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion._core import VISIBLE, project
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.clusters import polar_to_plane
from edgefusion.types import Cluster, Detection, Scan

Image = npt.NDArray[np.uint8]
Color = Tuple[int, int, int]

# Tells neighbours apart on photographs and on the dark ground of the scan, for colour-blind eyes too (Okabe, Ito).
PALETTE: tuple[Color, ...] = (
    (0, 159, 230),
    (233, 180, 86),
    (115, 158, 0),
    (66, 228, 240),
    (0, 94, 213),
    (167, 121, 204),
    (178, 114, 0),
)
BACKGROUND: Color = (34, 30, 28)
GRID: Color = (72, 66, 62)
GREY: Color = (150, 150, 150)
WHITE: Color = (245, 245, 245)
FONT = cv2.FONT_HERSHEY_SIMPLEX


def annotate(
    image: Image,
    detections: Sequence[Detection],
    scan: Scan,
    clusters: Sequence[Cluster],
    calibration: Calibration,
) -> Image:
    """The image with the scan's beams, coloured by cluster, and every detection's box, name and distance.

    The boxes that lost the vote are drawn thin.
    """
    picture = image.copy()
    scale = max(picture.shape[1] / 1280, 0.5)
    _draw_beams(picture, scan, clusters, calibration, radius=max(1, round(2 * scale)))
    for detection in reversed(detections):  # the nearest on top
        _draw_box(picture, detection, _color_of(detection.cluster, clusters), scale)
    return picture


def draw_scan(scan: Scan, clusters: Sequence[Cluster], detections: Sequence[Detection], side_px: int = 800) -> Image:
    """The scan from above, the robot looking up the picture, with rings of distance and the detections' names."""
    view = _TopView(scan, side_px)
    picture: Image = np.full((side_px, side_px, 3), BACKGROUND, np.uint8)
    view.draw_rings(picture)
    view.draw_beams(picture, np.flatnonzero(np.isfinite(scan.ranges_m)), GREY, radius=1)
    for cluster in clusters:
        view.draw_beams(picture, cluster.indices, _color_of(cluster, clusters), radius=3)
    for detection in detections:
        view.draw_name(picture, detection, _color_of(detection.cluster, clusters))
    view.draw_robot(picture)
    return picture


def _color_of(cluster: Cluster, clusters: Sequence[Cluster]) -> Color:
    number = next(i for i, other in enumerate(clusters) if other.indices[0] == cluster.indices[0])
    return PALETTE[number % len(PALETTE)]


def _name(detection: Detection) -> str:
    return f"{detection.group or detection.label} {detection.distance_m:.2f} m"


def _draw_beams(picture: Image, scan: Scan, clusters: Sequence[Cluster], calibration: Calibration, radius: int) -> None:
    for cluster in clusters:
        plane = polar_to_plane(scan.ranges_m[cluster.indices].astype(float), scan.angles[cluster.indices])
        points = np.pad(plane, ((0, 0), (0, 1)))
        pixels, marks = project(points, calibration.camera, calibration.T_camera_laser)
        for x, y in pixels[marks == VISIBLE]:
            if 0 <= x < picture.shape[1] and 0 <= y < picture.shape[0]:
                center = (round(x), round(y))
                cv2.circle(picture, center, radius, _color_of(cluster, clusters), cv2.FILLED, cv2.LINE_AA)


def _draw_box(picture: Image, detection: Detection, color: Color, scale: float) -> None:
    for x0, y0, x1, y1 in detection.boxes:
        cv2.rectangle(picture, (x0, y0), (x1 - 1, y1 - 1), color, 1)
    x0, y0, x1, y1 = detection.box
    cv2.rectangle(picture, (x0, y0), (x1 - 1, y1 - 1), color, max(2, round(3 * scale)), cv2.LINE_AA)
    draw_tag(picture, _name(detection), (x0, y0), color, 0.55 * max(scale, 0.8))


def draw_tag(picture: Image, text: str, corner: tuple[int, int], color: Color, scale: float) -> None:
    """Text on a filled tab above a corner, moved inside the picture."""
    (width, height), base = cv2.getTextSize(text, FONT, scale, 1)
    x = max(0, min(corner[0], picture.shape[1] - width - 6))
    y = max(height + base + 4, corner[1])
    cv2.rectangle(picture, (x, y - height - base - 4), (x + width + 6, y), color, cv2.FILLED)
    ink = (0, 0, 0) if sum(color) > 330 else WHITE
    cv2.putText(picture, text, (x + 3, y - base - 1), FONT, scale, ink, 1, cv2.LINE_AA)


class _TopView:
    """Maps the laser's plane into the picture: x forward is up, y left is left."""

    def __init__(self, scan: Scan, side_px: int) -> None:
        ranges_m = scan.ranges_m[np.isfinite(scan.ranges_m)]
        # Most of the scan: a single far beam would shrink everything else to a dot.
        self.reach_m = float(np.clip(np.percentile(ranges_m, 90) * 1.15, 2.0, 40.0)) if len(ranges_m) else 5.0
        with np.errstate(invalid="ignore"):  # inf along an axis: drawn nowhere
            self.points = polar_to_plane(scan.ranges_m.astype(float), scan.angles)
        behind = bool((self.points[np.isfinite(scan.ranges_m), 0] < -0.5).any())
        self.origin = (side_px // 2, side_px // 2 if behind else round(side_px * 0.93))
        self.px_per_m = (0.48 if behind else 0.88) * side_px / self.reach_m

    def pixel(self, point: npt.NDArray[np.float64]) -> tuple[int, int]:
        x, y = np.clip(point, -1e4, 1e4)
        return (round(self.origin[0] - y * self.px_per_m), round(self.origin[1] - x * self.px_per_m))

    def draw_rings(self, picture: Image) -> None:
        step_m = next(step for step in (0.5, 1, 2, 5, 10) if self.reach_m / step <= 8 or step == 10)
        for radius_m in np.arange(step_m, self.reach_m * 1.5, step_m):
            radius = round(float(radius_m) * self.px_per_m)
            cv2.circle(picture, self.origin, radius, GRID, 1, cv2.LINE_AA)
            where = (self.origin[0] + 4, self.origin[1] - radius - 4)
            cv2.putText(picture, f"{radius_m:g} m", where, FONT, 0.42, GREY, 1, cv2.LINE_AA)

    def draw_beams(self, picture: Image, indices: npt.NDArray[np.int64], color: Color, radius: int) -> None:
        for point in self.points[indices]:
            cv2.circle(picture, self.pixel(point), radius, color, cv2.FILLED, cv2.LINE_AA)

    def draw_name(self, picture: Image, detection: Detection, color: Color) -> None:
        pixels = [self.pixel(point) for point in self.points[detection.cluster.indices]]
        x, y = max(pixels)  # beside its right end, so that no beam is covered
        draw_tag(picture, _name(detection), (x + 10, y + 8), color, 0.45)

    def draw_robot(self, picture: Image) -> None:
        x, y = self.origin
        nose = np.array([[x, y - 14], [x - 9, y + 8], [x + 9, y + 8]], np.int32).reshape(-1, 1, 2)
        cv2.fillPoly(picture, [nose], WHITE, cv2.LINE_AA)
