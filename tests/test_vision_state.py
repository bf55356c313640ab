# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How well vision says that it sees: each reason is one by which somebody can help."""

from __future__ import annotations

from typing import Optional

import pytest

from bus_base import detection
from camera_scenes import scene
from edgefusion.perception.detector import StageTimes
from edgefusion.service.vision_look import Look
from edgefusion.service.vision_state import Circumstances, VisionState
from edgefusion.types import Frame, HealthState, Pose2D
from vision_scenes import MS, scan

START_NS = 5_000 * MS
WELL = Circumstances()


def look(ended_ns: int, pose: Optional[Pose2D] = Pose2D()) -> Look:  # noqa: B008
    stamp_ns = ended_ns - 90 * MS
    times = StageTimes(1 * MS, 2 * MS, 30 * MS, 4 * MS)
    frame = Frame(stamp_ns, scene(1))
    return Look(scan(stamp_ns), frame, pose, (detection(stamp_ns),), times, ended_ns - 40 * MS, ended_ns)


def seeing(pose: Optional[Pose2D] = Pose2D()) -> VisionState:  # noqa: B008
    state = VisionState(START_NS, 0.1)
    state.scanned(START_NS)
    state.looked(look(START_NS, pose))
    return state


def test_before_the_first_look_it_starts_and_then_it_is_well() -> None:
    assert VisionState(START_NS, 0.1).health(START_NS, WELL).state is HealthState.STARTING
    assert seeing().health(START_NS, WELL).state is HealthState.OK


@pytest.mark.parametrize(
    ("after_ms", "circumstances", "state", "reason"),
    [
        (
            0,
            Circumstances(trouble="CAMERA_LOST: unplugged"),
            HealthState.FAILED,
            "sees nothing: CAMERA_LOST: unplugged",
        ),
        (2100, WELL, HealthState.FAILED, "NO_SCANS: none for 2 s"),
        (2100, Circumstances(refused="another clock"), HealthState.FAILED, "SCANS_REFUSED: another clock"),
        (0, Circumstances(note="cuda failed"), HealthState.DEGRADED, "cuda failed"),
    ],
)
def test_what_keeps_it_from_seeing_is_said(
    after_ms: int, circumstances: Circumstances, state: HealthState, reason: str
) -> None:
    health = seeing().health(START_NS + after_ms * MS, circumstances)
    assert health.state is state
    assert health.reason.startswith(reason)


def test_scans_and_frames_that_never_meet_are_said_with_the_setting_that_keeps_them_apart() -> None:
    state = seeing()
    for after_ms in (1000, 2000, 3000):
        state.scanned(START_NS + after_ms * MS)
    assert "sync.tolerance_s = 0.1 s" in state.health(START_NS + 3000 * MS, WELL).reason


def test_without_odometry_it_is_degraded() -> None:
    health = seeing(pose=None).health(START_NS, WELL)
    assert health.state is HealthState.DEGRADED
    assert health.reason.startswith("NO_ODOMETRY")


def test_the_figures_are_medians_of_the_looks_with_their_units() -> None:
    state = VisionState(START_NS, 0.1)
    assert not state.figures()
    for number in range(11):
        state.looked(look(START_NS + number * 200 * MS))
    figures = state.figures()
    assert figures["infer [ms]"] == "30.0"
    assert figures["age when begun [ms]"] == "50.0"
    assert figures["age when known [ms]"] == "90.0"
    assert figures["frames [Hz]"] == "5.0"


def test_after_a_trouble_scans_and_frames_have_time_to_meet_again() -> None:
    state = seeing()
    lost, over_ns = Circumstances(trouble="CAMERA_LOST: unplugged"), START_NS + 9000 * MS
    state.scanned(over_ns)
    assert state.health(over_ns, lost).state is HealthState.FAILED
    assert state.health(over_ns + 1000 * MS, WELL).state is HealthState.STARTING
    state.looked(look(over_ns + 1500 * MS))
    assert state.health(over_ns + 1500 * MS, WELL).state is HealthState.OK


def test_a_camera_that_starts_is_no_failure() -> None:
    starts = Circumstances(trouble="CAMERA_STARTING: no picture yet")
    assert VisionState(START_NS, 0.1).health(START_NS, starts).state is HealthState.STARTING


def test_a_detector_that_takes_seconds_has_not_missed_its_scans() -> None:
    state = seeing()
    state.scanned(START_NS + 3000 * MS)
    state.looked(look(START_NS + 6000 * MS))
    assert state.health(START_NS + 6000 * MS, WELL).state is HealthState.OK
