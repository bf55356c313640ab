# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A supervisor and its children, whose faults are timed: `python -m benchmarks.supervised run FOLDER`.

The robot is at FOLDER/robot. The children are this module again, as `base FOLDER` and `vision FOLDER`.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

from edgefusion.config import BaseConfig, Config, PioneerConfig, ServiceConfig, VisionConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.service.children import children_of
from edgefusion.service.heartbeat import from_environment
from edgefusion.service.last_stop import stop_robot
from edgefusion.service.logs import set_up_logs
from edgefusion.service.signals import ended_by_signals
from edgefusion.service.supervisor import Supervisor
from edgefusion.types import Twist2D

_PERIOD_S = 0.05


def supervise(folder: Path) -> int:
    """With the limits and pauses that a robot has."""
    set_up_logs("supervisor")
    vision = VisionConfig(model="of another child", calibration="of another child")
    config = Config(service=ServiceConfig(processes=("base", "vision")), vision=vision)
    argv = (sys.executable, "-m", "benchmarks.supervised")
    specs = [replace(spec, argv=(*argv, spec.name, str(folder))) for spec in children_of(config, folder)]
    return Supervisor(specs, stop=partial(stop_robot, lock_folder=folder)).run()


def drive(folder: Path) -> int:
    """As base's thread of the robot does: a velocity every 50 ms. It says where its robot is."""
    beats, port = from_environment(), str(folder / "robot")
    link = Link(port, 9600, "the driving child", lock_folder=folder)
    due_s = 0.0
    with Pioneer(link, PioneerConfig(), BaseConfig()) as robot:
        robot.start()
        while not beats.parent_gone():
            beats.beat({"port": port, "baudrate": link.baudrate})
            if time.monotonic() >= due_s:
                robot.drive(Twist2D(0.3))
                due_s = time.monotonic() + _PERIOD_S
            robot.poll()
    return 0


def look(_: Path) -> int:
    """It lives, and says who it is."""
    beats = from_environment()
    while not beats.parent_gone():
        beats.beat({"says": str(os.getpid())})
        time.sleep(_PERIOD_S)
    return 0


if __name__ == "__main__":
    if sys.argv[1] == "run":
        sys.exit(supervise(Path(sys.argv[2])))
    with ended_by_signals():
        sys.exit((drive if sys.argv[1] == "base" else look)(Path(sys.argv[2])))
