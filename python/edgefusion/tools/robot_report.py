# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What `edgefusion robot` tells of a robot: as data, and in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping

from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.types import HealthState

_RING = 16


@dataclass(frozen=True)
class Counted:
    """packets_per_s: of the last seconds. reconnections: since the beginning."""

    packets_per_s: float = 0.0
    reconnections: int = 0


def facts(
    port: str, driver: Pioneer, state: RobotState | None, sonar_m: Mapping[int, float], counted: Counted
) -> dict[str, Any]:
    """Of one moment, for JSON. A sonar that heard nothing is null, one that did not fire lately is left out."""
    return {
        "port": port,
        "robot": _identity(driver),
        "state": None if state is None else _state(state, sonar_m),
        "packets_per_s": round(counted.packets_per_s, 1),
        "errors": {
            "skipped_bytes": driver.line.reader.finder.skipped_bytes,
            "unknown_packets": driver.line.reader.unknown_packets,
            "implausible_packets": driver.implausible_statuses,
            "reconnections": counted.reconnections,
        },
        "health": {"state": driver.health.state.value, "reason": driver.health.reason},
    }


def in_words(told: Mapping[str, Any]) -> list[str]:
    """The same as lines, always as many of them."""
    state, errors, health = told["state"], told["errors"], told["health"]
    words = "ok" if health["state"] == HealthState.OK.value else f"{health['state']}: {health['reason']}"
    return [
        f"port     {told['port']}{_speed_of(told['robot'])}",
        f"robot    {_named(told['robot'])}",
        f"health   {words}",
        *([f"{name:<9}-" for name in ("battery", "flags", "pose", "speed", "front", "rear")] if state is None else []),
        *([] if state is None else _state_in_words(state)),
        f"packets  {told['packets_per_s']:.1f}/s, {errors['unknown_packets']} of unknown types",
        f"errors   {errors['skipped_bytes']} bytes skipped, {errors['implausible_packets']} packets implausible, "
        f"{errors['reconnections']} reconnections",
    ]


def _identity(driver: Pioneer) -> dict[str, Any] | None:
    info = driver.info
    if info is None:
        return None
    return {
        "name": info.identity.name,
        "type": info.identity.type,
        "subtype": info.identity.subtype,
        "firmware": info.firmware,
        "baudrate": info.baudrate,
    }


def _state(state: RobotState, sonar_m: Mapping[int, float]) -> dict[str, Any]:
    pose, twist = state.odometry, state.twist
    return {
        "battery_v": round(state.battery_v, 1),
        "charging": state.charging,
        "motors_enabled": state.motors_enabled,
        "e_stop_pressed": state.e_stop_pressed,
        "stalled": [state.stalled_left, state.stalled_right],
        "front_bumpers": list(state.front_bumpers),
        "rear_bumpers": list(state.rear_bumpers),
        "pose": [round(pose.x_m, 3), round(pose.y_m, 3), round(math.degrees(pose.theta), 1)],
        "speed_mps": round(twist.v_mps, 3),
        "yaw_rate_dps": round(math.degrees(twist.w_radps), 1),
        "digital_in": state.digital_in,
        "digital_out": state.digital_out,
        "sonar_m": {str(n): round(m, 3) if math.isfinite(m) else None for n, m in sorted(sonar_m.items())},
    }


def _speed_of(robot: Mapping[str, Any] | None) -> str:
    return f", {robot['baudrate']} baud" if robot and robot["baudrate"] else ""


def _named(robot: Mapping[str, Any] | None) -> str:
    if robot is None:
        return "none"
    firmware = f", firmware {robot['firmware']}" if robot["firmware"] else ""
    return f"{robot['name']}: {robot['type']} {robot['subtype']}{firmware}"


def _state_in_words(state: Mapping[str, Any]) -> list[str]:
    charging = {None: "", True: ", charging", False: ", not charging"}[state["charging"]]
    x_m, y_m, degrees = state["pose"]
    return [
        f"battery  {state['battery_v']:.1f} V{charging}",
        f"flags    {_flags(state)}",
        f"pose     x {x_m:.3f} m, y {y_m:.3f} m, {degrees:.1f} degrees",
        f"speed    {state['speed_mps']:.3f} m/s, {state['yaw_rate_dps']:.1f} degrees/s",
        f"front    {_ring(state['sonar_m'], range(_RING // 2))}",
        f"rear     {_ring(state['sonar_m'], range(_RING // 2, _RING))}",
    ]


def _flags(state: Mapping[str, Any]) -> str:
    pressed = [
        f"{side} bumper {i + 1}" for side in ("front", "rear") for i, on in enumerate(state[f"{side}_bumpers"]) if on
    ]
    stalled = [f"{side} wheel stalled" for side, on in zip(("left", "right"), state["stalled"]) if on]
    e_stop = ["emergency stop pressed"] if state["e_stop_pressed"] else []
    return ", ".join([f"motors {'on' if state['motors_enabled'] else 'off'}", *e_stop, *stalled, *pressed])


def _ring(sonar_m: Mapping[str, float | None], numbers: range) -> str:
    """Of each sonar the metres, `far` where it heard nothing, a dash where it did not fire."""
    heard = [sonar_m.get(str(n), math.nan) for n in numbers]
    return " ".join(f"{'far':>5}" if m is None else f"{'-':>5}" if math.isnan(m) else f"{m:5.2f}" for m in heard)
