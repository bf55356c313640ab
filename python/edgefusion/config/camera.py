# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the camera: where its pictures come from, and when it counts as lost, frozen or blind."""

from __future__ import annotations

import sys
from typing import Optional, Union

import msgspec

from edgefusion.config.strict import Place, Seconds, UpTo1, UpTo10, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Pixels = Annotated[int, msgspec.Meta(ge=16, le=8192)]
Index = Annotated[int, msgspec.Meta(ge=0, le=255)]
CSI = "csi:"


class CameraConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where pictures come from, and when the camera counts as lost, frozen or blind.

    The times are those of the fault figures: lost within 0.5 s, frozen or blind within 1 s. What a device is to be set
    to may be left out: it then does what it does by itself.
    """

    source: Union[Index, Place] = 0
    """The number of a V4L2 device, its path, a video file, a URL, or "csi:0": the first CSI camera of a Jetson."""
    width: Optional[Pixels] = None
    """Of the pictures; one of another size is a fault. [px]"""
    height: Optional[Pixels] = None
    """As width, and only with it. [px]"""
    rate_hz: Optional[Annotated[float, msgspec.Meta(gt=0, le=1000)]] = None
    """Of the pictures; of a video file, how fast it plays."""
    exposure_s: Optional[UpTo1] = None
    """Set by hand; a long one blurs what passes by."""
    fourcc: Optional[Annotated[str, msgspec.Meta(pattern="^[A-Za-z0-9]{4}$")]] = None
    """Four letters, as "MJPG": few USB cameras give raw pictures fast enough."""
    exposure_offset_s: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0
    """How long before it arrives a picture is exposed (the middle of it): its stamp is so much earlier."""
    keep_s: UpTo10 = 1.0
    """The newest pictures of so long are kept."""
    lost_s: Seconds = 0.4
    """No picture for so long: lost."""
    frozen_s: Seconds = 0.8
    """The same picture for so long: frozen."""
    blind_s: Seconds = 0.5
    """Black, white or covered for so long: blind."""
    open_timeout_s: Seconds = 5.0
    """What does not open within so long is abandoned, and opened again after a pause."""
    read_timeout_s: Seconds = 1.0
    """What gives no picture within so long is abandoned, and opened again after a pause."""
    first_pause_s: Seconds = 0.1
    """The first pause before it is opened again; it doubles each time."""
    longest_pause_s: Seconds = 1.0
    """The pause doubles up to this."""
    gst_launch: Place = "gst-launch-1.0"
    """The program that brings pictures of CSI cameras."""

    def __post_init__(self) -> None:
        check_fields(self)
        if (self.width is None) != (self.height is None):
            raise RefusedError(f"width, height: expected both or neither, got {self.width} and {self.height}")
        if self.longest_pause_s < self.first_pause_s:
            raise RefusedError(
                f"longest_pause_s: expected at least first_pause_s, {self.first_pause_s:g}, "
                f"got {self.longest_pause_s:g}"
            )
        if self.rate_hz is not None:
            _check_rate(self.rate_hz, self)
        if self.is_csi:
            _check_csi(self)
        elif not self.is_v4l2:
            _check_not_settable(self)

    @property
    def is_v4l2(self) -> bool:
        """Whether it is a V4L2 device."""
        return isinstance(self.source, int) or self.source.startswith(("/dev/video", "/dev/v4l/"))

    @property
    def is_csi(self) -> bool:
        """Whether it is a CSI camera of a Jetson."""
        return isinstance(self.source, str) and self.source.startswith(CSI)

    @property
    def is_file(self) -> bool:
        """Whether it is a video file, which plays at its own rate, or at rate_hz, and ends."""
        return not (self.is_v4l2 or self.is_csi or "://" in str(self.source))

    @property
    def csi_sensor(self) -> int:
        """The number of the CSI camera."""
        return int(str(self.source)[len(CSI) :])


def _check_rate(rate_hz: float, settings: CameraConfig) -> None:
    if settings.lost_s * rate_hz < 2:
        raise RefusedError(f"lost_s: expected two pictures' time, {2 / rate_hz:g}, got {settings.lost_s:g}")
    if settings.exposure_s is not None and settings.exposure_s * rate_hz > 1:
        raise RefusedError(f"exposure_s: expected at most 1 / rate_hz, {1 / rate_hz:g}, got {settings.exposure_s:g}")


def _check_csi(settings: CameraConfig) -> None:
    number = str(settings.source)[len(CSI) :]
    if not (number.isascii() and number.isdigit() and len(number) == 1):
        raise RefusedError(f"source: expected a digit after {CSI}, got {settings.source!r}")
    if settings.width is None or settings.rate_hz is None:
        raise RefusedError(f"width, height, rate_hz: expected for {settings.source}, which sets none by itself")
    if settings.width % 4:  # GStreamer pads the lines of other widths
        raise RefusedError(f"width: expected a multiple of 4 for {settings.source}, got {settings.width}")
    if settings.fourcc is not None:
        raise RefusedError(f"fourcc: expected none for {settings.source}, got {settings.fourcc}")


def _check_not_settable(settings: CameraConfig) -> None:
    names = ("fourcc", "exposure_s") if settings.is_file else ("fourcc", "exposure_s", "rate_hz")
    given = [name for name in names if getattr(settings, name) is not None]
    if given:  # the source is not named: a URL may hold a password
        raise RefusedError(f"{', '.join(given)}: expected none for a file or URL, which cannot be set")
