# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A base with the devices of its robot."""

from __future__ import annotations

from pathlib import Path

from edgefusion.config import Config
from edgefusion.drivers.lms2xx import POWER_ON_BAUD, Lms2xx
from edgefusion.drivers.lms2xx_setup import configured_age_limit_s
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.service.base import Base, Watcher, nobody
from edgefusion.service.base_loop import BaseLoop
from edgefusion.service.ending import EndableLink

HOLDER = "edgefusion base"


def open_base(
    config: Config, robot_port: str, laser_port: str, watcher: Watcher = nobody, lock_folder: Path | None = None
) -> Base:
    """With a Pioneer and an LMS2xx; nothing is opened before it runs. Raises RefusedError for a footprint that no base
    can have."""
    robot_link = EndableLink(robot_port, config.robot.baudrates[0], HOLDER, lock_folder=lock_folder)
    laser_link = EndableLink(laser_port, POWER_ON_BAUD, HOLDER, lock_folder=lock_folder)
    return Base(
        BaseLoop(config, configured_age_limit_s(config.laser)),
        Pioneer(robot_link, config.robot, config.base),
        Lms2xx(laser_link, config.laser),
        (robot_link.ending, laser_link.ending),
        round(config.safety.cycle_s * 1e9),
        watcher,
    )
