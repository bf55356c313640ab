# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A supervisor in a process of its own: `python small_supervisor.py SPECS`, a JSON list of ChildSpecs."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path

from edgefusion.service.child_spec import ChildSpec, GiveUp
from edgefusion.service.last_stop import stop_robot
from edgefusion.service.logs import set_up_logs
from edgefusion.service.supervisor import Supervisor


def spec(fields: dict) -> ChildSpec:
    give_up = fields.pop("give_up", None)
    return ChildSpec(**fields, give_up=None if give_up is None else GiveUp(*give_up))


if __name__ == "__main__":
    set_up_logs("supervisor")
    specs, locks = json.loads(sys.argv[1]), Path(sys.argv[2])
    stop = partial(stop_robot, lock_folder=locks)
    sys.exit(Supervisor([spec(fields) for fields in specs], stop=lambda line, by_ns: stop(line, by_ns)).run())
