# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
import cv2
import msgspec
import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.perception.preprocessing import IMAGENET_MEAN, IMAGENET_STD, PAPER, Preprocessing, whole

IMAGE = np.random.default_rng(0).integers(0, 256, (60, 90, 3), np.uint8)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("size", 0),
        ("size", 4097),
        ("size", 100000),
        ("fit", "stretch"),
        ("filter", "cubic"),
        ("mean", (0.5, 0.5)),
        ("mean", (0.5, 0.5, float("nan"))),
        ("std", (0.2, 0.0, 0.2)),
        ("crop_fraction", 0.0),
        ("crop_fraction", 1.5),
        ("crop_fraction", 0.875),  # the fit is squash, which has no such thing
    ],
)
def test_a_value_that_cannot_be_is_refused_by_name(field, value):
    with pytest.raises(RefusedError, match=f"^{field}: expected .*, got "):
        Preprocessing(**{**msgspec.structs.asdict(PAPER), field: value})


def test_the_papers_is_a_squash_to_256_with_imagenets_colours():
    assert (PAPER.size, PAPER.fit, PAPER.mean, PAPER.std) == (256, "squash", IMAGENET_MEAN, IMAGENET_STD)


def test_linear_is_what_opencv_does():
    preprocessing = msgspec.structs.replace(PAPER, size=32, filter="linear")
    resized = cv2.resize(IMAGE[10:50, 20:80], (32, 32), interpolation=cv2.INTER_LINEAR)
    rgb = resized[..., ::-1].astype(np.float32) / 255
    expected = ((rgb - np.float32(IMAGENET_MEAN)) / np.float32(IMAGENET_STD)).transpose(2, 0, 1)
    got = preprocessing.apply(IMAGE, [[20, 10, 80, 50]])
    assert got.shape == (1, 3, 32, 32)
    assert got.dtype == np.float32
    one_grey_level = 1 / 255 / min(IMAGENET_STD)
    np.testing.assert_allclose(got[0], expected, atol=1.01 * one_grey_level)


def test_torchvisions_centre_leaves_the_margin_out():
    preprocessing = Preprocessing(
        size=56,
        fit="shorter-side+centre",
        filter="antialias",
        mean=(0.0, 0.0, 0.0),
        std=(1.0, 1.0, 1.0),
        crop_fraction=0.875,
    )
    image = np.zeros((64, 100, 3), np.uint8)
    image[4:60, 22:78] = 255  # the centre that 0.875 of the shorter side leaves
    assert preprocessing.apply(image, whole(image))[0].min() == 1.0


def test_crops_are_written_into_the_buffer_that_is_given():
    buffer = np.zeros((2, 3, PAPER.size, PAPER.size), np.float32)
    got = PAPER.apply(IMAGE, [[0, 0, 30, 30], [5, 5, 90, 60]], buffer)
    assert np.shares_memory(got, buffer)
    assert buffer.any()


@pytest.mark.parametrize("box", [(0, 0, 91, 60), (-1, 0, 10, 10), (10, 10, 10, 20)])
def test_a_box_that_is_empty_or_outside_is_refused(box):
    with pytest.raises(ValueError, match="box"):
        PAPER.apply(IMAGE, [box])


def test_whole_is_every_pixel():
    assert whole(IMAGE).tolist() == [[0, 0, 90, 60]]
