# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What keys of different sections cannot be together: with these the robot would never drive, or never for long."""

from __future__ import annotations

from typing import TYPE_CHECKING, Callable, Tuple

from edgefusion.errors import RefusedError

if TYPE_CHECKING:
    from edgefusion.config import Config

LEAST_HEARD_HZ, LEAST_SILENCE_S = 10.0, 0.2
"""Of an operator's heartbeats: all of them, and one that is lost is not their absence."""


def check_combinations(config: Config) -> None:
    """Raises RefusedError, which begins with the key that is to be changed."""
    for check in _CHECKS:
        check(config)


def _ports(config: Config) -> None:
    if config.robot.port == config.laser.port:
        raise RefusedError(f"laser.port: expected another one than robot.port, got {config.laser.port}")


def _scan_ages(config: Config) -> None:
    """A scan is as old as its telegram takes when it is there, and twice as old when the next one is."""
    least_s = 2 * config.laser.telegram_s
    for name, section in (("safety", config.safety), ("navigation", config.navigation)):
        if section.max_scan_age_s < least_s:
            raise RefusedError(
                f"{name}.max_scan_age_s: expected at least {least_s:.2g}, twice as long as laser.beams take at "
                f"laser.baudrate, got {section.max_scan_age_s:g}"
            )


def _cmd_vel(config: Config) -> None:
    """It is looked at once in a cycle."""
    cycle_s, timeout_s = config.safety.cycle_s, config.bus.cmd_vel_timeout_s
    if timeout_s < cycle_s:
        raise RefusedError(f"bus.cmd_vel_timeout_s: expected at least safety.cycle_s, {cycle_s:g}, got {timeout_s:g}")


def _base_silence(config: Config) -> None:
    """A sign of life comes with every cycle, also with one that is as long as it may be."""
    longest_s, silence_s = config.safety.max_cycle_s, config.service.base_silence_s
    if silence_s <= longest_s:
        raise RefusedError(
            f"service.base_silence_s: expected more than safety.max_cycle_s, {longest_s:g}, got {silence_s:g}"
        )


def _vision(config: Config) -> None:
    """Without a model there is none: that is well where the rest may do without it."""
    if "vision" not in config.service.processes or config.vision.model is not None:
        return
    if not config.service.drive_without_vision:
        raise RefusedError("vision.model: expected one where service.drive_without_vision is false, got none")
    if not config.processes:
        raise RefusedError("vision.model: expected one where service.processes is vision alone, got none")


def _without_vision(config: Config) -> None:
    """What was given up has failed for good."""
    drives_on = config.service.drive_without_vision and {"base", "vision"} <= set(config.processes)
    if drives_on and "vision" not in config.safety.optional:
        raise RefusedError(
            "safety.optional: expected vision among them where service.drive_without_vision is true, got "
            + (", ".join(config.safety.optional) or "none")
        )


def _operator(config: Config) -> None:
    """One who is there says so ten times a second, with what else they command."""
    if not config.bus.require_operator:
        return
    for name, value, least in (
        ("max_command_hz", config.bus.max_command_hz, LEAST_HEARD_HZ),
        ("operator_timeout_s", config.bus.operator_timeout_s, LEAST_SILENCE_S),
    ):
        if value < least:
            raise RefusedError(
                f"bus.{name}: expected at least {least:g} where bus.require_operator is true: an operator's heartbeat "
                f"comes every 0.1 s, got {value:g}"
            )


_CHECKS: Tuple[Callable[[Config], None], ...] = (
    _ports,
    _scan_ages,
    _cmd_vel,
    _base_silence,
    _vision,
    _without_vision,
    _operator,
)
