# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether a Pioneer may be driven, out of what it reports and what it was told."""

from __future__ import annotations

from edgefusion.config.pioneer import PioneerConfig
from edgefusion.drivers.pioneer_limits import Limits
from edgefusion.drivers.pioneer_state import RobotState
from edgefusion.types import Health, HealthState, Twist2D

COMPONENT = "robot"

DISOBEYS_NS = 700_000_000
"""For so long its wheels may do otherwise than told."""

BATTERY_NS = 5_000_000_000
"""A battery under load dips."""

_NS_PER_S = 1e9
_MOVES = 0.3
"""Share of the speed that is expected: less is none."""


class _Axis:
    """One of the two speeds: what it should be by now, given how the drive accelerates. least: too slow to judge."""

    def __init__(self, acceleration: float, least: float) -> None:
        self._acceleration, self._least = acceleration, least
        self._expected = self._change = 0.0

    def expect(self, commanded: float, dt_s: float) -> None:
        """A time has gone by since it was commanded something."""
        self._change = self._acceleration * dt_s
        self._expected += max(-self._change, min(self._change, commanded - self._expected))

    def fits(self, measured: float) -> bool:
        """Whether that is what it should be."""
        along = measured if self._expected >= 0 else -measured
        expected = abs(self._expected)
        too_fast = abs(measured) > expected + max(3 * self._least, self._change)
        return not too_fast and (expected < self._least or along >= _MOVES * expected)


class Judgement:
    """Looks at one state after the other."""

    def __init__(self, config: PioneerConfig, limits: Limits) -> None:
        self._config = config
        self._v = _Axis(limits.acceleration_mps2, 0.06)
        self._w = _Axis(limits.yaw_acceleration_radps2, 0.2)
        self._last: RobotState | None = None
        self._obeyed_ns = 0
        self._charged_ns: dict[float, int] = {}

    def judge(self, state: RobotState, commanded: Twist2D | None) -> Health:
        """FAILED: it must not be driven. DEGRADED: it may be, but somebody should know.

        commanded: None while it turns by its own control, where nobody knows what its wheels are to do.
        """
        disobeys = self._disobeys(state, commanded or state.twist)
        empty = self._below(self._config.empty_battery_v, state)
        low = self._below(self._config.low_battery_v, state)
        failures = [
            (state.e_stop_pressed, "the emergency stop is pressed"),
            (state.bumped, f"bumped: {_pressed(state)}"),
            (state.stalled, f"{_stalled(state)} stalled"),
            (not state.motors_enabled, "the motors are off"),
            (disobeys, "the wheels do not do what they were told"),
            (empty, f"the battery is empty: {state.battery_v:.1f} V"),
        ]
        reasons = [reason for holds, reason in failures if holds]
        if reasons:
            return Health(COMPONENT, HealthState.FAILED, "; ".join(reasons))
        if low:
            return Health(COMPONENT, HealthState.DEGRADED, f"the battery is low: {state.battery_v:.1f} V")
        return Health(COMPONENT, HealthState.OK)

    def _disobeys(self, state: RobotState, commanded: Twist2D) -> bool:
        """By the speeds that it says, and by where it got to: reports that are stuck say the same speed for ever."""
        last, self._last = self._last, state
        if last is None or state.stamp_ns <= last.stamp_ns:
            self._obeyed_ns = state.stamp_ns
            return False
        dt_s = (state.stamp_ns - last.stamp_ns) / _NS_PER_S
        self._v.expect(commanded.v_mps, dt_s)
        self._w.expect(commanded.w_radps, dt_s)
        step = state.odometry.relative_to(last.odometry)
        speeds = state.twist.v_mps, step.x_m / dt_s
        yaw_rates = state.twist.w_radps, step.theta / dt_s
        if all(map(self._v.fits, speeds)) and all(map(self._w.fits, yaw_rates)):
            self._obeyed_ns = state.stamp_ns
        return state.stamp_ns - self._obeyed_ns >= DISOBEYS_NS

    def _below(self, volts: float, state: RobotState) -> bool:
        if state.battery_v >= volts:
            self._charged_ns[volts] = state.stamp_ns
        since_ns = self._charged_ns.setdefault(volts, state.stamp_ns - BATTERY_NS)  # as low from the start
        return state.stamp_ns - since_ns >= BATTERY_NS


def _pressed(state: RobotState) -> str:
    sides = (("front", state.front_bumpers), ("rear", state.rear_bumpers))
    return ", ".join(f"{side} {i + 1}" for side, bumpers in sides for i, pressed in enumerate(bumpers) if pressed)


def _stalled(state: RobotState) -> str:
    wheels = [name for name, stalls in (("left", state.stalled_left), ("right", state.stalled_right)) if stalls]
    return "both wheels" if len(wheels) == 2 else f"{''.join(wheels)} wheel"
