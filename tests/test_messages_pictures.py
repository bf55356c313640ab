# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures and cameras as messages and back."""

from __future__ import annotations

import math
import struct
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import WireError
from edgefusion.messages.from_camera_info import from_camera_info
from edgefusion.messages.from_image import from_image
from edgefusion.messages.from_jpeg import from_jpeg
from edgefusion.messages.intrinsics import Intrinsics
from edgefusion.messages.pictures import decode_picture, encode_jpeg, picture_size
from edgefusion.messages.sensor_msgs import RegionOfInterest
from edgefusion.messages.to_camera_info import to_camera_info
from edgefusion.messages.to_image import to_image
from edgefusion.types import Frame
from messages_scenes import STAMP_NS, STAMPER, sent

RAMP = np.dstack([np.add.outer(np.arange(48), np.arange(64)).astype(np.uint8)] * 3)
JPEG = encode_jpeg(RAMP, 90)
PNG = cv2.imencode(".png", RAMP)[1].tobytes()
K = np.array([[500.0, 0.0, 320.0], [0.0, 510.0, 240.0], [0.0, 0.0, 1.0]])
CAMERA = Intrinsics((640, 480), K, (0.1, -0.2, 0.01, 0.02, 0.003))


def refused(data: bytes, reason: str) -> None:
    with pytest.raises(WireError, match=reason):
        decode_picture(data)


def claiming(size: int) -> bytes:
    """A JPEG that claims to be so wide and high."""
    at = JPEG.index(b"\xff\xc0")
    return JPEG[: at + 5] + struct.pack(">HH", size, size) + JPEG[at + 9 :]


def test_a_picture_comes_back_nearly_as_it_was() -> None:
    message = sent(from_image(Frame(STAMP_NS, RAMP), STAMPER, quality=95))
    assert message.format == "jpeg"
    assert message.header == STAMPER.header(STAMP_NS, "camera_optical")
    frame = to_image(message, STAMPER)
    assert frame.stamp_ns == STAMP_NS
    assert np.abs(frame.image.astype(int) - RAMP).max() < 8


def test_a_better_picture_is_larger() -> None:
    pictures = [from_image(Frame(STAMP_NS, RAMP), STAMPER, quality).data for quality in (10, 95)]
    assert len(pictures[0]) < len(pictures[1])


def test_a_jpeg_goes_as_it_is() -> None:
    assert from_jpeg(STAMP_NS, JPEG, STAMPER).data == JPEG


def test_a_png_comes_as_exactly_as_it_went() -> None:
    np.testing.assert_array_equal(decode_picture(PNG), RAMP)


@pytest.mark.parametrize("data", [JPEG, PNG, JPEG[:2] + b"\xff" + JPEG[2:]])
def test_a_picture_says_its_size_before_it_is_decoded(data: bytes) -> None:
    assert picture_size(data) == (64, 48)


def test_what_claims_to_be_huge_is_not_decoded() -> None:
    assert picture_size(claiming(65535)) == (65535, 65535)
    refused(claiming(65535), "expected at most 67108864 pixels, got 65535x65535")
    refused(claiming(0), "got 0x0")
    refused(PNG[:16] + struct.pack(">II", 2**31, 2**31) + PNG[24:], "expected at most 67108864 pixels")


def test_half_a_picture_is_refused_instead_of_grey() -> None:
    for data in (JPEG, PNG):
        refused(data[:-8], "picture: truncated")


def test_what_is_no_picture_is_refused() -> None:
    refused(b"", "expected a JPEG or PNG, got 0 bytes")
    refused(b"GIF89a", "expected a JPEG or PNG, got 6 bytes that begin with 474946383961")
    refused(b"\xff\xd8\xff\xd9", "expected a JPEG or PNG")
    refused(PNG[:24] + bytes(8) + PNG[-12:], "cannot decode")


@given(at=st.integers(0, len(JPEG) - 1), value=st.integers(0, 255), end=st.integers(0, len(JPEG)))
def test_any_damage_is_a_picture_or_refused(at: int, value: int, end: int) -> None:
    damaged = bytearray(JPEG)
    damaged[at] = value
    for data in (bytes(damaged), bytes(damaged[:end])):
        try:
            assert decode_picture(data).dtype == np.uint8
        except WireError as error:
            assert str(error).startswith("picture: ")


@pytest.mark.parametrize("quality", [0, 101])
def test_a_quality_that_jpeg_does_not_have_is_refused(quality: int) -> None:
    with pytest.raises(RefusedError, match=f"quality: expected 1 to 100, got {quality}"):
        encode_jpeg(RAMP, quality)


def test_what_jpeg_cannot_hold_is_refused() -> None:
    with pytest.raises(RefusedError, match="JPEG cannot hold"):
        encode_jpeg(np.zeros((1, 65536, 3), np.uint8), 80)


@pytest.mark.parametrize("coefficients", [5, 8, 12, 14])
def test_a_camera_comes_back(coefficients: int) -> None:
    camera = replace(CAMERA, distortion=tuple(0.01 * n for n in range(coefficients)))
    found = to_camera_info(sent(from_camera_info(STAMP_NS, camera, STAMPER)))
    assert (found.image_size, found.distortion) == (camera.image_size, camera.distortion)
    np.testing.assert_array_equal(found.K, K)


def test_a_simple_camera_is_a_plumb_bob_with_five_coefficients() -> None:
    for distortion in ((), (0.1, 0.2, 0.3, 0.4)):
        message = from_camera_info(STAMP_NS, replace(CAMERA, distortion=distortion), STAMPER)
        assert message.distortion_model == "plumb_bob"
        assert message.d == [*distortion, *[0.0] * (5 - len(distortion))]
        assert (message.width, message.height) == (640, 480)
        assert message.p == [500.0, 0.0, 320.0, 0.0, 0.0, 510.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        assert message.header.frame_id == "camera_optical"


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"distortion_model": "equidistant"}, "expected plumb_bob or rational_polynomial, got 'equidistant'"),
        ({"d": [0.0] * 6}, "6 coefficients are not 'plumb_bob'"),
        ({"d": [math.nan] * 5}, "distortion: expected"),
        ({"k": [0.0] * 9}, "focal lengths above 0"),
        ({"k": [math.nan] * 9}, "expected finite numbers"),
        ({"width": 0}, "image_size: expected above 0"),
        ({"binning_x": 2}, "expected no binning, got 2x0"),
        ({"roi": RegionOfInterest(width=10, height=10)}, "expected the whole picture"),
    ],
)
def test_a_camera_that_is_of_no_use_is_refused(changes: dict, reason: str) -> None:
    with pytest.raises(WireError, match=f"^camera_info: .*{reason}"):
        to_camera_info(replace(from_camera_info(STAMP_NS, CAMERA, STAMPER), **changes))
