# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Z9: what a router lets in from the network, by the sockets that its process really has open."""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable, List, Sequence

from benchmarks.fault_row import FaultRow
from benchmarks.faults_bus_rig import free_port, wait_for

from edgefusion.bus.router import open_router
from edgefusion.bus.session import open_session
from edgefusion.config import BusConfig, Config, ServiceConfig
from edgefusion.tools.doctor_bus import check_bus, exposures
from edgefusion.tools.doctor_finding import Examination, State
from edgefusion.tools.doctor_sockets import sockets_of

SETTLED_S = 0.5
"""What opens after the listener has opened by then."""


def open_to_the_network(tick: Callable[[], object]) -> FaultRow:
    """tick: called once."""
    usual = BusConfig(listen=(f"tcp/127.0.0.1:{free_port()}",))
    found = _exposures_of_the_process(usual)
    doctor = _doctor(usual, open_router), _doctor(usual, lambda _: open_session({"mode": "router"}))
    tick()
    failed = bool(found) or doctor != (State.OK, State.FAILED)
    told = f"{len(found)} open; the doctor says {doctor[0].value}, and {doctor[1].value} of Zenoh's own settings"
    what = "sockets of the usual `edgefusion bus` that are open to the network"
    return FaultRow("Z9", what, "0; doctor fails otherwise", math.inf, remark=told, failed=failed)


def _exposures_of_the_process(config: BusConfig) -> List[str]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "robot.toml")
        file.write_text(f"[bus]\nlisten = {_as_toml(config.listen)}\n", encoding="utf-8")
        process = subprocess.Popen([sys.executable, "-m", "edgefusion.cli", "bus", "--config", str(file)])
        try:
            proc = Path(f"/proc/{process.pid}")
            wait_for(lambda: any(each.listens for each in sockets_of(proc)))
            time.sleep(SETTLED_S)
            return exposures(sockets_of(proc), config.listen)
        finally:
            process.kill()
            process.wait()


def _doctor(config: BusConfig, opened: Callable[[BusConfig], object]) -> State:
    """The worst that it says of a router that is opened so."""
    whole = Config(bus=config, service=ServiceConfig(processes=("bus",)))
    findings = list(check_bus(Examination(whole, Path("robot.toml")), opened))
    return State.FAILED if any(each.state is State.FAILED for each in findings) else State.OK


def _as_toml(texts: Sequence[str]) -> str:
    return "[" + ", ".join(f'"{text}"' for text in texts) + "]"
