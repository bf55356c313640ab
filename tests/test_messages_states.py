# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Battery, health and mission as messages and back."""

from __future__ import annotations

import json
import math

import pytest

from edgefusion.messages.cdr import WireError
from edgefusion.messages.diagnostic_msgs import DiagnosticArray, DiagnosticStatus, KeyValue
from edgefusion.messages.from_battery import from_battery
from edgefusion.messages.from_healths import from_healths
from edgefusion.messages.from_mission import from_mission
from edgefusion.messages.mission_report import InspectionReport, MissionReport
from edgefusion.messages.sensor_msgs import BatteryState
from edgefusion.messages.std_msgs import String
from edgefusion.messages.to_battery import to_battery
from edgefusion.messages.to_healths import to_healths
from edgefusion.messages.to_mission import to_inspection, to_mission
from edgefusion.navigation.mission_step import MissionState
from edgefusion.types import Health, HealthState
from messages_scenes import STAMP_NS, STAMPER, sent

HEALTHS = [
    Health("laser", HealthState.OK),
    Health("robot", HealthState.STARTING, "no report yet"),
    Health("camera", HealthState.DEGRADED, "slow"),
    Health("vision", HealthState.FAILED, "five crashes in 60 s"),
]
INSPECTION = InspectionReport(
    id="inspection-1",
    label="oscilloscope",
    group="",
    score=0.75,
    distance_m=1.5,
    place_m=(3.0, 1.0),
    pose=(1.5, 1.0, 0.0),
    begun_ns=STAMP_NS,
    stood_ns=None,
    ended_ns=STAMP_NS + 1,
    picture_ns=None,
    reason="no picture within 3 s",
)
MISSION = MissionReport(
    stamp_ns=STAMP_NS,
    state="inspecting",
    goal_id="goal-1",
    goal_m=(5.0, 5.5),
    pose=(1.5, 1.0, 0.0),
    way_left_m=2.5,
    note="standing: oscilloscope",
    result=INSPECTION,
)


@pytest.mark.parametrize(
    ("charging", "status"),
    [
        (None, BatteryState.POWER_SUPPLY_STATUS_UNKNOWN),
        (True, BatteryState.POWER_SUPPLY_STATUS_CHARGING),
        (False, BatteryState.POWER_SUPPLY_STATUS_DISCHARGING),
    ],
)
def test_a_battery_comes_back(charging: bool | None, status: int) -> None:
    message = sent(from_battery(STAMP_NS, 12.5, STAMPER, charging))
    assert message.power_supply_status == status
    assert message.present
    assert to_battery(message, STAMPER) == (STAMP_NS, 12.5, charging)


def test_what_nobody_measures_of_a_battery_is_nan() -> None:
    message = from_battery(STAMP_NS, 12.5, STAMPER)
    unknown = (message.temperature, message.current, message.charge, message.capacity, message.percentage)
    assert all(map(math.isnan, unknown))


@pytest.mark.parametrize("voltage_v", [-1.0, math.nan, math.inf])
def test_a_voltage_that_is_none_is_refused(voltage_v: float) -> None:
    with pytest.raises(WireError, match="battery: expected 0 V or more"):
        to_battery(from_battery(STAMP_NS, voltage_v, STAMPER), STAMPER)


def test_healths_come_back_with_their_figures() -> None:
    message = sent(from_healths(STAMP_NS, HEALTHS, STAMPER, {"vision": {"infer_ms": "12.5"}}))
    assert [report.health for report in to_healths(message)] == HEALTHS
    assert [report.figures for report in to_healths(message)] == [{}, {}, {}, {"infer_ms": "12.5"}]


def test_healths_have_the_levels_of_ros() -> None:
    levels = [status.level for status in from_healths(STAMP_NS, HEALTHS, STAMPER).status]
    assert levels == [DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.WARN, DiagnosticStatus.ERROR]


@pytest.mark.parametrize(
    ("state", "reason"), [("well", "'well' is not a valid"), ("failed", "expected why laser is failed, got none")]
)
def test_a_health_that_is_none_is_refused(state: str, reason: str) -> None:
    status = DiagnosticStatus(0, "laser", "", "edgefusion", [KeyValue("state", state)])
    with pytest.raises(WireError, match=f"diagnostics: laser: .*{reason}"):
        to_healths(DiagnosticArray(status=[status]))


def test_the_diagnostics_of_other_nodes_are_left_out() -> None:
    assert to_healths(DiagnosticArray(status=[DiagnosticStatus(2, "joystick", "unplugged", "gamepad")])) == []


def test_a_report_of_the_mission_comes_back() -> None:
    assert to_mission(sent(from_mission(MISSION))) == MISSION
    assert to_inspection(sent(from_mission(INSPECTION))) == INSPECTION


@pytest.mark.parametrize("state", [state.value for state in MissionState])
def test_the_mission_has_the_states_of_navigation(state: str) -> None:
    content = {"version": 1, "stamp_ns": 1, "state": state}
    assert to_mission(String(json.dumps(content))).state == state


@pytest.mark.parametrize("changes", [{"state": "flying"}, {"version": 2}, {"pose": [1.0, 2.0]}, {"extra": 1}])
def test_a_report_that_is_none_is_refused(changes: dict) -> None:
    content = {**json.loads(from_mission(MISSION).data), **changes}
    with pytest.raises(WireError, match=r"^mission: .*"):
        to_mission(String(json.dumps(content)))
    with pytest.raises(WireError, match=r"^inspection/meta: .*"):
        to_inspection(String(json.dumps(content)))


def test_a_report_without_a_goal_has_no_field_that_older_readers_would_refuse() -> None:
    report = MissionReport(stamp_ns=1, state="idle")
    content = json.loads(from_mission(report).data)
    assert set(content) == {
        "version", "stamp_ns", "state", "reason", "goal_id", "pose", "way_left_m", "clearance_m", "paused", "note",
        "result",
    }  # fmt: skip
    assert to_mission(String(json.dumps(content))) == report


def test_where_there_is_no_way_none_is_left() -> None:
    report = to_mission(from_mission(MissionReport(stamp_ns=1, state="idle", way_left_m=math.inf)))
    assert report.way_left_m is None
