# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Crops are what Pillow or OpenCV would give, normalized, however box and image lie."""

import itertools
from pathlib import Path
from typing import Any, Tuple

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from edgefusion._core import crops

Pixels = npt.NDArray[np.uint8]
Crops = npt.NDArray[np.float32]
Box = Tuple[int, int, int, int]

unhurried = settings(deadline=None)  # a busy machine is no error

NONE = ([0, 0, 0], [1, 1, 1])
MEAN, STD = [0.485, 0.456, 0.406], [0.229, 0.224, 0.225]
FILTERS = ["antialias", "linear"]
FITS = ["squash", "letterbox", "square-context", "shorter-side+centre"]
BILINEAR = Image.Resampling.BILINEAR if hasattr(Image, "Resampling") else Image.BILINEAR


def noise(height: int, width: int, seed: int = 0) -> Pixels:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


def grey_levels(image: Pixels, box: Box, size: int, **options: Any) -> Crops:
    """One crop as RGB [size, size, 3] in 0..255, not rounded."""
    crop = crops(image, [box], size, *NONE, **options)[0]
    return np.ascontiguousarray(crop.transpose(1, 2, 0)) * np.float32(255)


def by_pillow(image: Pixels, box: Box, size: Tuple[int, int]) -> Pixels:
    rgb = Image.fromarray(np.ascontiguousarray(image[:, :, ::-1]))
    return np.asarray(rgb.crop(box).resize(size, BILINEAR))


def by_opencv(image: Pixels, box: Box, size: Tuple[int, int]) -> Pixels:
    x0, y0, x1, y1 = box
    crop = np.ascontiguousarray(image[y0:y1, x0:x1])
    return cv2.resize(crop, size, interpolation=cv2.INTER_LINEAR)[:, :, ::-1]


def by_reference(image: Pixels, box: Box, size: Tuple[int, int], filter: str) -> Pixels:
    return by_pillow(image, box, size) if filter == "antialias" else by_opencv(image, box, size)


def by_torchvision(image: Pixels, box: Box, size: int, fraction: float) -> Pixels:
    """Resize(round(size / fraction)) and CenterCrop(size), as torchvision computes their sizes, by Pillow."""
    width, height = box[2] - box[0], box[3] - box[1]
    short, long = min(width, height), max(width, height)
    requested = round(size / fraction)
    resized = (requested, int(requested * long / short))
    w, h = resized if width <= height else resized[::-1]
    top, left = round((h - size) / 2.0), round((w - size) / 2.0)
    return by_pillow(image, box, (w, h))[top : top + size, left : left + size]


def assert_within_one_level(ours: Crops, reference: Pixels) -> None:
    # Pillow rounds twice, half a level each: a value that is not rounded may be a whole level and a bit away.
    assert ours.shape == reference.shape
    assert np.abs(ours - reference.astype(np.float32)).max() <= 1.02
    assert np.abs(np.rint(ours) - reference).max() <= 1


@st.composite
def images(draw: st.DrawFn, most: int = 130) -> Pixels:
    height, width = draw(st.integers(1, most)), draw(st.integers(1, most))
    image = noise(height, width, draw(st.integers(0, 2**32 - 1)))
    return draw(st.sampled_from([image, (image // 128 * 255).astype(np.uint8)]))


@st.composite
def scenes(draw: st.DrawFn) -> Tuple[Pixels, Box]:
    image = draw(images())
    height, width = image.shape[:2]
    x0, y0 = draw(st.integers(0, width - 1)), draw(st.integers(0, height - 1))
    return image, (x0, y0, draw(st.integers(x0 + 1, width)), draw(st.integers(y0 + 1, height)))


# --- the pixels ---------------------------------------------------------------------------------------------


@unhurried
@given(scenes(), st.integers(1, 200))
def test_antialias_is_within_a_grey_level_of_pillow(scene: Tuple[Pixels, Box], size: int) -> None:
    image, box = scene
    assert_within_one_level(grey_levels(image, box, size), by_pillow(image, box, (size, size)))


@unhurried
@given(scenes(), st.integers(1, 200))
def test_linear_is_within_a_grey_level_of_opencv(scene: Tuple[Pixels, Box], size: int) -> None:
    image, box = scene
    assert_within_one_level(grey_levels(image, box, size, filter="linear"), by_opencv(image, box, (size, size)))


@unhurried
@given(scenes(), st.integers(1, 150), st.sampled_from([0.5, 0.875, 224 / 232, 1.0]))
def test_shorter_side_and_centre_is_torchvisions(scene: Tuple[Pixels, Box], size: int, fraction: float) -> None:
    image, box = scene
    ours = grey_levels(image, box, size, fit="shorter-side+centre", crop_fraction=fraction)
    assert_within_one_level(ours, by_torchvision(image, box, size, fraction))


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("box", [(0, 0, 2592, 1944), (100, 50, 2500, 1900), (2000, 3, 2592, 1944), (7, 7, 2590, 9)])
@pytest.mark.parametrize("size", [1, 5, 256, 512])
def test_a_large_camera_is_no_exception(box: Box, size: int, filter: str) -> None:
    image = noise(1944, 2592)
    ours = grey_levels(image, box, size, filter=filter)
    assert_within_one_level(ours, by_reference(image, box, (size, size), filter))


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("shape", [(1, 5000), (5000, 1), (1, 1), (2, 5000)])
@pytest.mark.parametrize("size", [1, 2, 224, 512])
def test_extreme_shapes_are_no_exception(shape: Tuple[int, int], size: int, filter: str) -> None:
    image = noise(*shape)
    box = (0, 0, shape[1], shape[0])
    ours = grey_levels(image, box, size, filter=filter)
    assert_within_one_level(ours, by_reference(image, box, (size, size), filter))


@pytest.mark.parametrize("filter", FILTERS)
def test_real_images_are_no_exception(shared_data: Path, filter: str) -> None:
    paths = sorted(itertools.chain(*(shared_data.glob(f"images/**/*{end}") for end in (".jpg", ".png"))))[:20]
    for path in paths:
        image = cv2.imread(str(path))
        height, width = image.shape[:2]
        box = (width // 7, height // 5, width - width // 9, height)
        ours = grey_levels(image, box, 224, filter=filter)
        assert_within_one_level(ours, by_reference(image, box, (224, 224), filter))


@pytest.mark.parametrize("fit", FITS)
@pytest.mark.parametrize("filter", FILTERS)
def test_a_box_as_large_as_the_square_keeps_its_pixels(fit: str, filter: str) -> None:
    image = noise(300, 300)
    ours = grey_levels(image, (20, 30, 244, 254), 224, fit=fit, filter=filter)
    np.testing.assert_array_equal(np.rint(ours), image[30:254, 20:244, ::-1])
    np.testing.assert_allclose(ours, np.rint(ours), atol=1e-4)


@unhurried
@given(scenes(), st.integers(1, 60), st.sampled_from(FILTERS), st.integers(0, 255))
def test_a_flat_box_stays_flat_whatever_surrounds_it(
    scene: Tuple[Pixels, Box], size: int, filter: str, level: int
) -> None:
    image, (x0, y0, x1, y1) = scene
    image[y0:y1, x0:x1] = level
    ours = grey_levels(image, (x0, y0, x1, y1), size, filter=filter)
    np.testing.assert_allclose(ours, level, rtol=1e-6, atol=1e-6)


def test_channels_come_out_as_red_green_blue_with_their_own_mean_and_std() -> None:
    blue_green_red = np.array([10, 100, 250], np.uint8)
    image = np.broadcast_to(blue_green_red, (9, 9, 3))
    crop = crops(image, [[1, 1, 8, 7]], 5, MEAN, STD)[0]
    expected = (blue_green_red[::-1] / 255 - np.array(MEAN)) / np.array(STD)
    np.testing.assert_allclose(crop, np.broadcast_to(expected[:, None, None], (3, 5, 5)), atol=2e-6)


@unhurried
@given(scenes(), st.integers(1, 40))
def test_normalization_is_exact(scene: Tuple[Pixels, Box], size: int) -> None:
    image, box = scene
    plain, normalized = (crops(image, [box], size, *how)[0].transpose(1, 2, 0) for how in (NONE, (MEAN, STD)))
    np.testing.assert_allclose(normalized, (plain.astype(float) - MEAN) / STD, atol=5e-6)


# --- where things lie ---------------------------------------------------------------------------------------

VIEWS = {
    "every second row, mirrored": lambda a: a[::2, ::-1],
    "channels reversed": lambda a: a[..., ::-1],
    "upside down": lambda a: a[::-1],
    "mirrored": lambda a: a[:, ::-1],
    "all reversed": lambda a: a[::-1, ::-1, ::-1],
    "transposed": lambda a: a.transpose(1, 0, 2),
    "a part": lambda a: a[3:-5, 7:-2],
    "every third column": lambda a: a[:, ::3],
    "planar": lambda a: np.ascontiguousarray(a.transpose(2, 0, 1)).transpose(1, 2, 0),
    "one row, repeated": lambda a: np.broadcast_to(a[:1], a.shape),
    "BGR of BGRA": lambda a: np.concatenate([a, a[:, :, :1]], axis=2)[:, :, :3],
    "read-only": lambda a: np.frombuffer(a.tobytes(), np.uint8).reshape(a.shape),
    "Fortran": np.asfortranarray,
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("size", [9, 64, 300])
def test_strides_do_not_matter(view: str, filter: str, size: int) -> None:
    image = VIEWS[view](noise(120, 150))
    height, width = image.shape[:2]
    boxes = [[0, 0, width, height], [width - 20, height - 30, width, height], [2, 3, 19, 14], [0, 0, 1, 1]]
    ours, copied = (crops(i, boxes, size, MEAN, STD, filter=filter) for i in (image, image.copy()))
    np.testing.assert_array_equal(ours, copied)


@unhurried
@given(scenes(), st.integers(1, 64), st.sampled_from(FITS), st.sampled_from(FILTERS))
def test_boxes_do_not_influence_each_other(scene: Tuple[Pixels, Box], size: int, fit: str, filter: str) -> None:
    image, box = scene
    height, width = image.shape[:2]
    boxes = [[0, 0, width, height], box, [width - 1, height - 1, width, height]]
    together = crops(image, boxes, size, MEAN, STD, fit=fit, filter=filter)
    for crop, alone in zip(together, boxes):
        np.testing.assert_array_equal(crop, crops(image, [alone], size, MEAN, STD, fit=fit, filter=filter)[0])


# --- the fits -----------------------------------------------------------------------------------------------


def padded(content: Pixels, top: int, left: int, size: int) -> Pixels:
    square = np.zeros((size, size, 3), np.uint8)
    square[top : top + content.shape[0], left : left + content.shape[1]] = content
    return square


def test_a_letterbox_is_the_whole_box_centred_on_the_mean_colour() -> None:
    image = noise(100, 200)
    wide, tall = (10, 10, 110, 60), (10, 10, 21, 99)
    content = by_pillow(image, wide, (64, 32))
    assert_within_one_level(grey_levels(image, wide, 64, fit="letterbox"), padded(content, 16, 0, 64))
    content = by_pillow(image, tall, (8, 64))  # 64 * 11 / 89 = 7.9
    assert_within_one_level(grey_levels(image, tall, 64, fit="letterbox"), padded(content, 0, 28, 64))
    crop = crops(image, [wide], 64, MEAN, STD, fit="letterbox")[0]
    assert not crop[:, :16].any() and not crop[:, 48:].any() and crop[:, 16:48].all()


@pytest.mark.parametrize(
    ("box", "square"),
    [
        ((50, 40, 90, 60), (50, 30, 90, 70)),  # around the box
        ((50, 0, 90, 20), (50, 0, 90, 40)),  # moved down
        ((50, 85, 90, 100), (50, 60, 90, 100)),  # moved up
        ((0, 40, 10, 70), (0, 40, 30, 70)),  # moved right
        ((195, 40, 200, 70), (170, 40, 200, 70)),  # moved left
    ],
)
def test_square_context_is_the_square_around_the_box_moved_inside(box: Box, square: Box) -> None:
    image = noise(100, 200)
    ours = grey_levels(image, box, 48, fit="square-context")
    np.testing.assert_array_equal(ours, grey_levels(image, square, 48))


def test_square_context_is_padded_where_the_image_ends() -> None:
    image = noise(100, 200)
    # 160 wide: rows -30..130 centre it, of which 0..100 exist.
    content = by_pillow(image, (20, 0, 180, 100), (80, 50))
    ours = grey_levels(image, (20, 40, 180, 60), 80, fit="square-context")
    assert_within_one_level(ours, padded(content, 15, 0, 80))


@unhurried
@given(scenes(), st.integers(1, 64), st.sampled_from(FITS), st.sampled_from(FILTERS))
def test_every_value_of_the_buffer_is_written(scene: Tuple[Pixels, Box], size: int, fit: str, filter: str) -> None:
    image, box = scene
    out = np.full((1, 3, size, size), np.nan, np.float32)
    crops(image, [box], size, *NONE, fit=fit, filter=filter, out=out)
    assert (out >= 0).all() and (out <= 1 + 1e-6).all()


# --- the call -----------------------------------------------------------------------------------------------


def test_the_buffer_given_is_the_one_returned() -> None:
    image = noise(50, 50)
    out = np.empty((2, 3, 8, 8), np.float32)
    boxes = np.array([[0, 0, 9, 9], [5, 5, 50, 50]], np.int32)
    assert crops(image, boxes, 8, MEAN, STD, out=out) is out
    np.testing.assert_array_equal(out, crops(image, boxes, 8, MEAN, STD))


@pytest.mark.parametrize("boxes", [[], np.zeros((0, 4), np.int32), np.zeros((0, 4))], ids=["list", "int32", "float64"])
def test_no_boxes_give_no_crops(boxes: Any) -> None:
    crop = crops(noise(4, 4), boxes, 16, MEAN, STD)
    assert crop.shape == (0, 3, 16, 16) and crop.dtype == np.float32


READ_ONLY = np.zeros((1, 3, 8, 8), np.float32)
READ_ONLY.flags.writeable = False


@pytest.mark.parametrize(
    "out",
    [
        np.zeros((2, 3, 8, 8), np.float32),
        np.zeros((1, 3, 8, 9), np.float32),
        np.zeros((1, 3, 8, 8)),
        np.zeros((1, 3, 8, 16), np.float32)[..., ::2],
        np.zeros((3, 8, 8), np.float32),
        READ_ONLY,
    ],
    ids=["number", "size", "type", "strides", "dimensions", "read-only"],
)
def test_a_wrong_buffer_is_refused(out: Crops) -> None:
    with pytest.raises(ValueError, match=r"out: expected a writeable contiguous float32 array \[1, 3, 8, 8\]"):
        crops(noise(9, 9), [[0, 0, 9, 9]], 8, MEAN, STD, out=out)


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (noise(9, 9)[..., 0], "image: expected shape"),
        (np.zeros((9, 9, 4), np.uint8), "image: expected shape"),
        (np.zeros((9, 9, 3), np.float32), "image: expected uint8, got float32"),
        (noise(9, 9).tolist(), "image: expected a uint8 array, got list"),
        (np.broadcast_to(noise(1, 1), (1, 2**31 + 9, 3)), "image: expected at most 268435456 pixels a side"),
        (np.broadcast_to(noise(1, 1), (2**32 + 9, 1, 3)), "image: expected at most 268435456 pixels a side"),
    ],
)
def test_another_image_is_refused(image: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        crops(image, [[0, 0, 9, 9]], 8, MEAN, STD)


@pytest.mark.parametrize(
    ("box", "why"),
    [
        ((5, 2, 5, 4), "empty"),
        ((5, 4, 6, 2), "empty"),
        ((-1, 0, 3, 3), "not inside the image"),
        ((0, -7, 3, 3), "not inside the image"),
        ((0, 0, 41, 3), "not inside the image"),
        ((0, 0, 3, 31), "not inside the image"),
        ((90, 90, 95, 95), "not inside the image"),
        ((-(2**31), 0, 2**31 - 1, 3), "not inside the image"),
        ((0, 0, 2**32 + 3, 3), "not inside the image"),
        ((-(2**32), 0, 3, 3), "not inside the image"),
        ((0, -(2**63), 3, 2**63 - 1), "not inside the image"),
    ],
)
def test_a_box_that_cannot_be_cropped_is_refused_by_index_values_and_image(box: Box, why: str) -> None:
    out = np.full((2, 3, 8, 8), 7, np.float32)
    with pytest.raises(ValueError) as refusal:
        crops(noise(30, 40), [(0, 0, 40, 30), box], 8, MEAN, STD, out=out)
    assert str(refusal.value) == f"boxes[1]: {box} is {why}; image 40 x 30"
    assert (out == 7).all(), "nothing is written before all boxes are known to be good"


@pytest.mark.parametrize("type", [np.int8, np.uint8, np.int16, np.uint16, np.uint32, np.int64, np.uint64, ">i4"])
def test_boxes_may_be_integers_of_any_width(type: Any) -> None:
    image, boxes = noise(30, 40), [[1, 2, 30, 20], [0, 0, 9, 9]]
    np.testing.assert_array_equal(
        crops(image, np.array(boxes, type), 8, MEAN, STD), crops(image, np.array(boxes, np.int32), 8, MEAN, STD)
    )


def test_an_unsigned_box_does_not_wrap_around() -> None:
    with pytest.raises(ValueError, match=r"^boxes\[0\]: \(0, 0, 18446744073709551615, 3\) is not inside the image"):
        crops(noise(9, 9), np.array([[0, 0, 2**64 - 1, 3]], np.uint64), 8, MEAN, STD)


@pytest.mark.parametrize(
    ("boxes", "message"),
    [
        (np.array([[0, 0, 3.7, 3]]), "boxes: expected integers, got float64"),
        (np.array([[0, 0, 3, 3]], np.float32), "boxes: expected integers, got float32"),
        ([[0, 0, np.nan, 3]], "boxes: expected integers, got float64"),
        ([["0", "0", "3", "3"]], "boxes: expected integers, got <U1"),
        ([[False, False, True, True]], "boxes: expected integers, got bool"),
        ([[0, 0, 3, 3 + 0j]], "boxes: expected integers, got complex128"),
        ([[0, 0, 3, None]], "boxes: expected integers, got object"),
        ([0, 0, 3, 3], r"boxes: expected shape \[n, 4\], got \[4\]"),
        (np.zeros((0, 3), int), r"boxes: expected shape \[n, 4\], got \[0, 3\]"),
    ],
)
def test_boxes_that_are_no_integers_are_refused_not_rounded(boxes: Any, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        crops(noise(9, 9), boxes, 8, MEAN, STD)


@pytest.mark.parametrize("name", ["mean", "std"])
@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1, 1], r"expected shape \[3\], got \[2\]"),
        (np.ones((3, 1)), r"expected shape \[3\], got \[3, 1\]"),
        (1.0, r"expected shape \[3\], got \[\]"),
        (["1", "1", "1"], "expected real numbers, got <U1"),
    ],
)
def test_a_mean_or_std_that_is_no_triple_is_refused_by_shape(name: str, value: Any, message: str) -> None:
    options = {"mean": MEAN, "std": STD, name: value}
    with pytest.raises(ValueError, match=f"^{name}: {message}$"):
        crops(noise(9, 9), [[0, 0, 9, 9]], 8, **options)


def test_mean_and_std_may_be_arrays() -> None:
    image, boxes = noise(9, 9), [[0, 0, 9, 9]]
    arrays = crops(image, boxes, 8, np.array(MEAN), np.array(STD, np.float32))
    np.testing.assert_array_equal(arrays, crops(image, boxes, 8, MEAN, STD))


def test_a_number_that_is_refused_is_shown_in_full() -> None:
    with pytest.raises(ValueError, match=r"^crop_fraction: expected above 0 and at most 1, got 1\.0000001$"):
        crops(noise(9, 9), [], 8, MEAN, STD, crop_fraction=1.0000001)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": 0}, "size"),
        ({"size": -3}, "size"),
        ({"std": [1, 0, 1]}, "std"),
        ({"std": [1, -1, 1]}, "std"),
        ({"std": [1, 1, float("nan")]}, "std"),
        ({"std": [1, 1, float("inf")]}, "std"),
        ({"mean": [float("nan"), 0, 0]}, "mean"),
        ({"mean": [0, float("inf"), 0]}, "mean"),
        ({"crop_fraction": 0}, "crop_fraction"),
        ({"crop_fraction": -0.5}, "crop_fraction"),
        ({"crop_fraction": 1.01}, "crop_fraction"),
        ({"crop_fraction": float("nan")}, "crop_fraction"),
        ({"fit": "stretch"}, "fit"),
        ({"filter": "cubic"}, "filter"),
    ],
)
def test_an_option_without_meaning_is_refused_by_name(options: Any, message: str) -> None:
    good = {"size": 4, "mean": MEAN, "std": STD}
    with pytest.raises(ValueError, match=f"^{message}: expected"):
        crops(noise(9, 9), [[0, 0, 9, 9]], **{**good, **options})
