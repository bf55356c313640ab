# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From settings to what captures: GStreamer's command, OpenCV's settings, what is refused, what is kept secret."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from camera_scenes import wait_until
from edgefusion.clock import SimClock
from edgefusion.config import Config, convert
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_open import gstreamer_command, open_source, source_name
from edgefusion.drivers.camera_pipe import PipeEndedError
from edgefusion.drivers.camera_v4l2 import apply_settings
from edgefusion.errors import RefusedError

CSI = {"source": "csi:1", "width": 64, "height": 48, "rate_hz": 30.0}


class Device:
    """Remembers what it is set to, and takes nothing of what it refuses."""

    def __init__(self, *refused: int) -> None:
        self.refused, self.taken = refused, []

    def set(self, property_id: int, value: float) -> bool:
        if property_id in self.refused:
            return False
        self.taken.append((property_id, value))
        return True


def test_a_device_gets_format_size_rate_and_exposure_in_this_order() -> None:
    device = Device()
    config = CameraConfig(width=640, height=480, rate_hz=30.0, exposure_s=0.008, fourcc="MJPG")
    assert apply_settings(device, config) == []
    assert device.taken == [
        (cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*"MJPG")),
        (cv2.CAP_PROP_FRAME_WIDTH, 640),
        (cv2.CAP_PROP_FRAME_HEIGHT, 480),
        (cv2.CAP_PROP_FPS, 30.0),
        (cv2.CAP_PROP_AUTO_EXPOSURE, 1),
        (cv2.CAP_PROP_EXPOSURE, 80),
    ]


def test_a_device_is_left_as_it_is_where_nothing_is_configured() -> None:
    device = Device()
    assert apply_settings(device, CameraConfig()) == []
    assert device.taken == []


def test_what_a_device_does_not_take_is_named() -> None:
    device = Device(cv2.CAP_PROP_FPS, cv2.CAP_PROP_EXPOSURE)
    assert apply_settings(device, CameraConfig(rate_hz=30.0, exposure_s=0.01)) == ["rate_hz", "exposure_s"]


def test_the_command_of_a_csi_camera_names_sensor_size_rate_and_exposure() -> None:
    words = gstreamer_command(CameraConfig(**CSI, exposure_s=0.01))
    assert words[:5] == [
        "gst-launch-1.0",
        "-q",
        "nvarguscamerasrc",
        "sensor-id=1",
        "exposuretimerange=10000000 10000000",
    ]
    assert "video/x-raw(memory:NVMM),width=64,height=48,framerate=30000/1000" in words
    assert words[-3:] == ["fdsink", "fd=3", "sync=false"]
    assert words.count("!") == 7


def fake_gst(path: Path, script: str) -> str:
    path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    path.chmod(0o755)
    return str(path)


def test_pictures_of_a_csi_camera_come_beside_what_its_plug_ins_print(tmp_path: Path) -> None:
    script = 'echo "GST_ARGUS: Creating output stream"; head -c 9216 /dev/zero | tr "\\0" "\\007" >&3; sleep 60'
    program = fake_gst(tmp_path / "gst", script)
    source, pictures = open_source(CameraConfig(**CSI, gst_launch=program), SimClock(42)), []
    try:
        wait_until(lambda: pictures.append(source.read(0.05)) or pictures[-1] is not None)
    finally:
        source.close()
    assert pictures[-1].arrival_ns == 42
    assert pictures[-1].image.shape == (48, 64, 3)
    assert set(pictures[-1].image.ravel()) == {7}


def test_what_the_csi_program_says_last_is_the_reason(tmp_path: Path) -> None:
    program = fake_gst(tmp_path / "gst", 'echo "ERROR: no cameras available"; exit 1')
    source = open_source(CameraConfig(**CSI, gst_launch=program), SimClock())
    try:
        with pytest.raises(PipeEndedError, match="ERROR: no cameras available"):
            wait_until(lambda: source.read(0.05) is not None)
    finally:
        source.close()


@pytest.mark.parametrize(("source", "name"), [(255, "/dev/video255"), ("no/such/film.avi", "no/such/film.avi")])
def test_what_is_not_there_is_named_without_starting_anything(source, name: str) -> None:
    with pytest.raises(PipeEndedError, match=f"{name}: not there"):
        open_source(CameraConfig(source=source), SimClock())


def test_a_password_in_a_url_is_not_shown() -> None:
    assert source_name(CameraConfig(source="rtsp://me:secret@cam.local/live")) == "rtsp://cam.local/live"
    assert source_name(CameraConfig(source="http://cam.local/a@b")) == "http://cam.local/a@b"
    assert source_name(CameraConfig(source=2)) == "/dev/video2"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"source": -1}, "source: "),
        ({"source": 1.5}, "source: "),
        ({"source": ""}, "source: "),
        ({"width": 640}, "width, height: expected both or neither"),
        ({"rate_hz": 3.0}, "lost_s: expected two pictures' time, 0.666667, got 0.4"),
        ({"first_pause_s": 2.0}, "longest_pause_s: expected at least first_pause_s, 2, got 1"),
        ({"fourcc": "MJPEG"}, "fourcc: "),
        ({"exposure_s": float("nan")}, "exposure_s: "),
        ({**CSI, "source": "csi:"}, "source: expected a digit after csi:"),
        ({**CSI, "source": "csi:x"}, "source: expected a digit after csi:"),
        ({**CSI, "width": 66}, "width: expected a multiple of 4 for csi:1, got 66"),
        ({**CSI, "fourcc": "MJPG"}, "fourcc: expected none for csi:1"),
        ({"source": "csi:0"}, "width, height, rate_hz: expected for csi:0"),
        ({"source": "http://cam/", "exposure_s": 0.01, "rate_hz": 30.0}, "exposure_s, rate_hz: expected none for a"),
        ({"source": "film.avi", "fourcc": "MJPG"}, "fourcc: expected none for a file"),
    ],
)
def test_impossible_settings_are_refused_with_one_line(settings, message: str) -> None:
    with pytest.raises(RefusedError, match=message) as refused:
        CameraConfig(**settings)
    assert "\n" not in str(refused.value)


def test_the_configuration_file_has_a_section_for_it() -> None:
    config = convert({"camera": {"source": "film.avi", "rate_hz": 10.0}}, Config, Path("robot.toml"))
    assert config.camera == CameraConfig(source="film.avi", rate_hz=10.0)
    with pytest.raises(RefusedError, match=r"robot.toml: .*colour"):
        convert({"camera": {"colour": True}}, Config, Path("robot.toml"))
