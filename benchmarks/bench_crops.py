# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Three crops of one image, to 256 x 256 and normalized, against Pillow and OpenCV on one thread."""

from typing import Any, Callable, Dict, List, Optional, Tuple

import cv2
import numpy as np
import numpy.typing as npt
from benchmarks.timing import Row, interleaved
from PIL import Image

from edgefusion._core import crops
from edgefusion.perception.preprocessing import Filter

Pixels = npt.NDArray[Any]
Floats = npt.NDArray[Any]
Boxes = List[Tuple[int, int, int, int]]

SIZE = 256
MEAN = np.array([0.485, 0.456, 0.406], np.float32)
STD = np.array([0.229, 0.224, 0.225], np.float32)
SCALE = 1 / (255 * STD)
OFFSET = -MEAN / STD


def paper_boxes(width: int) -> Boxes:
    """The paper's three candidates of one object: as wide as it, 0.6, 1 and 1.6 times as high."""
    return [(40, 40, 40 + width, 40 + round(width * shape)) for shape in (0.6, 1.0, 1.6)]


def by_pillow(image: Image.Image, boxes: Boxes) -> Floats:
    batch = []
    for box in boxes:
        crop = np.asarray(image.crop(box).resize((SIZE, SIZE), Image.Resampling.BILINEAR), np.float32) / 255
        batch.append(((crop - MEAN) / STD).transpose(2, 0, 1))
    return np.stack(batch)


def resized(image: Pixels, boxes: Boxes) -> List[Pixels]:
    return [cv2.resize(image[y0:y1, x0:x1], (SIZE, SIZE)) for x0, y0, x1, y1 in boxes]


def by_opencv(image: Pixels, boxes: Boxes, out: Floats, plane: Callable[[Pixels, int, Floats], object]) -> None:
    for crop, target in zip(resized(image, boxes), out):
        for channel, values in zip((2, 1, 0), cv2.split(crop)):
            plane(values, channel, target[channel])


def by_numpy_plane(values: Pixels, channel: int, out: Floats) -> None:
    np.multiply(values, SCALE[channel], out=out)
    np.add(out, OFFSET[channel], out=out)


def by_weighted_plane(values: Pixels, channel: int, out: Floats) -> None:
    scale, offset = float(SCALE[channel]), float(OFFSET[channel])
    cv2.addWeighted(values, scale, values, 0, offset, dst=out, dtype=cv2.CV_32F)


TABLES = np.arange(256, dtype=np.float32) * SCALE[:, None] + OFFSET[:, None]


def by_table_plane(values: Pixels, channel: int, out: Floats) -> None:
    cv2.LUT(values, TABLES[channel], dst=out)


def by_blob(image: Pixels, boxes: Boxes) -> Floats:
    scale, mean = [float(v) for v in SCALE], [float(v) for v in 255 * MEAN]
    params = cv2.dnn.Image2BlobParams(scale, (SIZE, SIZE), mean, swapRB=True)
    return cv2.dnn.blobFromImagesWithParams([image[y0:y1, x0:x1] for x0, y0, x1, y1 in boxes], params)


def opencv_recipes(image: Pixels, boxes: Boxes) -> Dict[str, Callable[[], object]]:
    out = np.zeros((len(boxes), 3, SIZE, SIZE), np.float32)
    planes = {"numpy": by_numpy_plane, "addWeighted": by_weighted_plane, "LUT": by_table_plane}
    recipes: Dict[str, Callable[[], object]] = {
        f"OpenCV, {name}": lambda plane=plane: by_opencv(image, boxes, out, plane)  # type: ignore[misc]
        for name, plane in planes.items()
    }
    recipes["OpenCV, blobFromImages"] = lambda: by_blob(image, boxes)
    return recipes


def product(image: Pixels, boxes: Boxes, filter: Filter) -> Callable[[], Floats]:
    out = np.zeros((len(boxes), 3, SIZE, SIZE), np.float32)
    array = np.array(boxes, np.int32)
    mean, std = [float(v) for v in MEAN], [float(v) for v in STD]
    return lambda: crops(image, array, SIZE, mean, std, filter=filter, out=out)


def scene_rows(name: str, image: Pixels, boxes: Boxes, aims: Tuple[Optional[float], ...], rounds: int) -> List[Row]:
    rgb = Image.fromarray(np.ascontiguousarray(image[:, :, ::-1]))
    recipes = opencv_recipes(image, boxes)
    median = interleaved(
        {
            "antialias": product(image, boxes, "antialias"),
            "linear": product(image, boxes, "linear"),
            "Pillow + numpy": lambda: by_pillow(rgb, boxes),
            **recipes,
        },
        rounds,
    )
    peers = {"antialias": "Pillow + numpy", "linear": min(recipes, key=lambda recipe: median[recipe])}
    return [
        Row(f"crops {filter}, {name}", median[filter], peer, median[peer], median[peer] / median[filter], aim)
        for (filter, peer), aim in zip(peers.items(), aims)
    ]


def rows(rounds: int = 50) -> List[Row]:
    """The rows of the common table; sets OpenCV to one thread, which the product has."""
    cv2.setNumThreads(1)
    random = np.random.default_rng(0)
    hd = random.integers(0, 256, (720, 1280, 3), dtype=np.uint8)
    large = random.integers(0, 256, (1944, 2592, 3), dtype=np.uint8)
    table: List[Row] = []
    for width in (100, 200, 300):
        table += scene_rows(f"3 boxes {width} wide of 1280 x 720", hd, paper_boxes(width), (8, 2), rounds)
    table += scene_rows("3 boxes 1100 wide of 2592 x 1944", large, paper_boxes(1100), (None, None), rounds)
    return table


if __name__ == "__main__":
    for row in rows():
        aim = "" if row.aim is None else f" (aim {row.aim:g})"
        ours, peers = 1e6 * row.product_s, 1e6 * row.peer_s
        print(f"{row.name}: {ours:.0f} us, {row.peer} {peers:.0f} us, {row.ratio:.1f} times{aim}")
