# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base with the devices of its robot."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, NamedTuple

from edgefusion.config import Config
from edgefusion.drivers.lms2xx import POWER_ON_BAUD, Lms2xx
from edgefusion.drivers.lms2xx_setup import configured_age_limit_s
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.service.base import Base, Ear, Inlet, Watcher, alone, nobody
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.device_thread import nothing
from edgefusion.service.ending import EndableLink
from edgefusion.service.laser_device import nobody as deaf

HOLDER = "edgefusion base"


class Lines(NamedTuple):
    """To robot and laser; not open until a base runs on them."""

    robot: EndableLink
    laser: EndableLink


def lines_to(config: Config, robot_port: str, laser_port: str, lock_folder: Path | None = None) -> Lines:
    """To a Pioneer and an LMS2xx."""
    return Lines(
        EndableLink(robot_port, config.robot.baudrates[0], HOLDER, lock_folder=lock_folder),
        EndableLink(laser_port, POWER_ON_BAUD, HOLDER, lock_folder=lock_folder),
    )


def loop_of(config: Config) -> BaseLoop:
    """With an LMS2xx's scans. Raises RefusedError for a footprint that no base can have."""
    return BaseLoop(config, configured_age_limit_s(config.laser))


def base_on(
    config: Config,
    lines: Lines,
    loop: BaseLoop,
    watcher: Watcher = nobody,
    inlet: Inlet = alone,
    prepare: Callable[[], object] = nothing,
    ear: Ear = deaf,
) -> Base:
    """With a Pioneer and an LMS2xx."""
    return Base(
        loop,
        Pioneer(lines.robot, config.robot, config.base),
        Lms2xx(lines.laser, config.laser),
        (lines.robot.ending, lines.laser.ending),
        round(config.safety.cycle_s * 1e9),
        watcher,
        inlet,
        prepare=prepare,
        ear=ear,
    )


def open_base(
    config: Config, robot_port: str, laser_port: str, watcher: Watcher = nobody, lock_folder: Path | None = None
) -> Base:
    """One without a bus; nothing is opened before it runs. Raises RefusedError as loop_of."""
    return base_on(config, lines_to(config, robot_port, laser_port, lock_folder), loop_of(config), watcher)
