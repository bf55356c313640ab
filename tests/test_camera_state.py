# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a camera is, at known times: the limits of the fault figures C1 to C3."""

from __future__ import annotations

import pytest

from camera_scenes import flat, scene
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_state import CameraState
from edgefusion.types import HealthState

MS = 1_000_000
PERIOD_NS = 33 * MS


def test_before_the_first_picture_it_is_starting() -> None:
    health = CameraState(CameraConfig()).health(10**12)
    assert (health.component, health.state) == ("camera", HealthState.STARTING)


def test_pictures_that_come_make_it_well() -> None:
    state = CameraState(CameraConfig())
    for number in range(100):
        state.take(number * PERIOD_NS, scene(number))
        assert state.health(number * PERIOD_NS + 5 * MS).state is HealthState.OK


def test_silence_is_lost_within_half_a_second_without_anyone_telling() -> None:
    state = CameraState(CameraConfig())
    state.take(0, scene(0))
    assert state.health(399 * MS).state is HealthState.OK
    assert state.health(401 * MS).reason.startswith("CAMERA_LOST")
    assert state.health(500 * MS).state is HealthState.FAILED


def test_a_picture_from_the_future_does_not_count() -> None:
    state = CameraState(CameraConfig())
    state.take(100 * MS, scene(0))
    assert state.health(99 * MS).reason.startswith("CAMERA_LOST")


def test_a_failure_is_lost_at_once_and_over_with_the_next_picture() -> None:
    state = CameraState(CameraConfig())
    state.take(0, scene(0))
    state.fail("/dev/video0: not there")
    assert state.health(1 * MS).reason == "CAMERA_LOST: /dev/video0: not there"
    state.take(2 * MS, scene(1))
    assert state.health(3 * MS).state is HealthState.OK


def first_fault_ns(images, code: str) -> int:
    """When the health first shows the code, as pictures come at 30 Hz."""
    state = CameraState(CameraConfig())
    for number, image in enumerate(images):
        state.take(number * PERIOD_NS, image)
        if state.health(number * PERIOD_NS).reason.startswith(code):
            return number * PERIOD_NS
    raise AssertionError(f"{code} never came")


def test_the_same_picture_is_frozen_within_a_second_and_not_before_its_time() -> None:
    assert 800 * MS <= first_fault_ns([scene(0)] * 40, "CAMERA_FROZEN") <= 1000 * MS


@pytest.mark.parametrize(("level", "word"), [(0, "black"), (255, "white"), (100, "covered")])
def test_pictures_of_nothing_are_blind_within_a_second_and_named(level: int, word: str) -> None:
    assert 500 * MS <= first_fault_ns([flat(level)] * 40, "CAMERA_BLIND") <= 1000 * MS
    assert first_fault_ns([flat(level)] * 40, f"CAMERA_BLIND: {word}") <= 1000 * MS


def test_a_lens_that_is_covered_and_uncovered_again_is_not_blind_for_long() -> None:
    state = CameraState(CameraConfig())
    for number in range(30):
        state.take(number * PERIOD_NS, flat(100 + number % 2))
    assert state.fault
    state.take(30 * PERIOD_NS, scene(0))
    assert state.fault == ""
    assert state.health(30 * PERIOD_NS).state is HealthState.OK


def test_a_blink_is_not_blind() -> None:
    state = CameraState(CameraConfig())
    for number in range(90):
        state.take(number * PERIOD_NS, flat(0) if number % 10 else scene(number))
        assert state.fault == ""


def test_a_frozen_camera_stays_frozen_while_it_is_opened_again() -> None:
    state = CameraState(CameraConfig())
    for number in range(30):
        state.take(number * PERIOD_NS, scene(0))
    assert state.is_frozen
    assert state.health(60 * PERIOD_NS).reason.startswith("CAMERA_FROZEN")
    state.take(60 * PERIOD_NS, scene(0))
    assert state.is_frozen
    state.take(61 * PERIOD_NS, scene(1))
    assert state.health(61 * PERIOD_NS).state is HealthState.OK
