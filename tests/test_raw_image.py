# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Raw pictures of ROS become BGR, whatever their encoding, and only what they say they are."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.messages.builtin_interfaces import Time
from edgefusion.messages.cdr import WireError, decode, encode
from edgefusion.messages.sensor_msgs import Image
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.std_msgs import Header
from edgefusion.messages.to_raw_image import to_raw_image

WIDTH, HEIGHT = 8, 6
PICTURE = np.random.default_rng(3).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
FLAT = np.full((HEIGHT, WIDTH, 3), (200, 120, 40), np.uint8)
"""Blue 200, green 120, red 40."""


def message(encoding: str, pixels: npt.NDArray[np.uint8], padding: int = 0) -> Image:
    rows = pixels.reshape(len(pixels), -1)
    rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=99)
    header = Header(Time(12, 5), "camera")
    return Image(header, *pixels.shape[:2], encoding, 0, rows.shape[1], rows.tobytes())


@pytest.mark.parametrize(
    ("encoding", "pixels"),
    [
        ("bgr8", PICTURE),
        ("8UC3", PICTURE),
        ("rgb8", PICTURE[..., ::-1]),
        ("bgra8", np.dstack([PICTURE, PICTURE[..., 0]])),
        ("rgba8", np.dstack([PICTURE[..., ::-1], PICTURE[..., 0]])),
    ],
)
@pytest.mark.parametrize("padding", [0, 5])
def test_colours_come_in_the_order_blue_green_red(encoding: str, pixels: npt.NDArray[np.uint8], padding: int) -> None:
    frame = to_raw_image(decode(Image, encode(message(encoding, pixels, padding))), Stamper())
    assert (frame.image == PICTURE).all()
    assert frame.stamp_ns == 12_000_000_005


@pytest.mark.parametrize("encoding", ["mono8", "8UC1"])
def test_a_grey_picture_is_grey_in_all_colours(encoding: str) -> None:
    frame = to_raw_image(message(encoding, PICTURE[..., 0], padding=3), Stamper())
    assert (frame.image == PICTURE[..., :1]).all()


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_of_a_bayer_pattern_every_colour_is_where_its_name_says(pattern: str) -> None:
    colours = {"b": 200, "g": 120, "r": 40}
    tile = np.array([[colours[pattern[0]], colours[pattern[1]]], [colours[pattern[2]], colours[pattern[3]]]], np.uint8)
    frame = to_raw_image(message(f"bayer_{pattern}8", np.tile(tile, (HEIGHT // 2, WIDTH // 2))), Stamper())
    assert (frame.image == FLAT).all()


@pytest.mark.parametrize(("encodings", "order"), [(("uyvy", "yuv422"), (1, 0)), (("yuyv", "yuv422_yuy2"), (0, 1))])
def test_pictures_of_webcams_keep_their_colour(encodings: tuple[str, str], order: tuple[int, int]) -> None:
    y, u, v = (np.full((HEIGHT, WIDTH), value, np.uint8) for value in (150, 90, 170))
    chroma = np.where(np.arange(WIDTH) % 2, v, u)
    pixels = np.dstack([(y, chroma)[order[0]], (y, chroma)[order[1]]])
    expected = [
        1.164 * (150 - 16) + 2.018 * (90 - 128),
        1.164 * 134 - 0.813 * 42 - 0.391 * -38,
        1.164 * 134 + 1.596 * 42,
    ]
    for encoding in encodings:
        image = to_raw_image(message(encoding, pixels), Stamper()).image
        assert np.abs(image - np.array(expected)).max() < 2


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"encoding": "32FC1"}, "encoding: expected one of bgr8, .*got '32FC1'"),
        ({"encoding": "mono16"}, "encoding: "),
        ({"height": 0, "data": b""}, "expected pixels, got 8x0"),
        ({"step": 23}, "8x6 bgr8 with a step of 23: expected a step of 24"),
        ({"step": 25}, "6 times as many bytes, got 144"),
        ({"data": bytes(143)}, "got 143"),
        ({"height": 2**32 - 1}, "got 144"),
        ({"encoding": "yuyv", "width": 7, "step": 24}, "7x6 cannot be"),
    ],
)
def test_a_picture_that_cannot_be_is_refused(change: dict[str, object], named: str) -> None:
    with pytest.raises(WireError, match=named):
        to_raw_image(replace(message("bgr8", PICTURE), **change), Stamper())


@given(st.sampled_from(["bgr8", "mono8", "bayer_rggb8", "uyvy"]), st.integers(0, 40), st.integers(0, 40), st.data())
def test_any_sizes_are_a_picture_or_refused(encoding: str, height: int, width: int, data: st.DataObject) -> None:
    step = data.draw(st.integers(0, 130))
    given_data = bytes(data.draw(st.sampled_from([step * height, step * height + 1])))
    try:
        frame = to_raw_image(Image(Header(), height, width, encoding, 0, step, given_data), Stamper())
    except WireError:
        return
    assert frame.image.shape == (height, width, 3)
    assert cv2.imencode(".png", frame.image)[0]
