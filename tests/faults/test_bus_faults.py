# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of the bus against the processes that a robot runs: Z2 and Z9; how long it takes is `make faults`'s matter."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import List

import pytest

from base_lab import wait_for
from bus_lab import free_port, make_keys
from bus_robot import BusRobot
from edgefusion.errors import RefusedError
from edgefusion.tools.doctor_bus import exposures
from edgefusion.tools.doctor_sockets import Socket, sockets_of

ATTENDS = """
import sys, time
from edgefusion import connect
with connect(sys.argv[1]) as robot, robot.attend():
    time.sleep(1000)
"""


def sets_off(it: BusRobot, robot) -> bool:
    """With a goal, and once more where a machine that is too busy had it given up."""
    mission = robot.status.mission
    if mission is None or mission.state in ("idle", "stopped"):
        for ask in (robot.resume, lambda: robot.goto(3.0, 0.0)):
            with suppress(RefusedError, ConnectionError):
                ask()
    return it.moving()


def test_z2_an_operator_who_is_required_and_halted_stops_the_robot_which_stays_also_when_he_goes_on(tmp_path) -> None:
    with BusRobot(tmp_path, "require_operator = true") as it:
        robot = it.start("bus", "base").connect()
        operator = subprocess.Popen([sys.executable, "-c", ATTENDS, it.endpoint])
        it.processes["operator"] = operator
        wait_for(lambda: sets_off(it, robot))
        operator.send_signal(signal.SIGSTOP)
        since_ns = time.monotonic_ns()
        assert it.stopped_after_s(since_ns) < 3.0  # 0.5 s and a cycle on a machine with nothing else to do
        wait_for(lambda: robot.status.mission.reason == "no heartbeat of an operator for 0.5 s")
        with pytest.raises(RefusedError, match="no heartbeat"):
            robot.resume()
        stood_ns = time.monotonic_ns()
        operator.send_signal(signal.SIGCONT)
        time.sleep(0.5)
        assert it.velocities(stood_ns) <= {0}
        robot.resume()  # he is there again, and so it may go on
        wait_for(it.moving)


def opened_by(verb_arguments: List[str], ports: List[int]) -> List[Socket]:
    """Of a process with these listeners, once it has opened them."""
    process = subprocess.Popen([sys.executable, "-m", "edgefusion.cli", *verb_arguments])
    try:
        folder = Path(f"/proc/{process.pid}")
        wait_for(lambda: set(ports) <= {each.port for each in sockets_of(folder) if each.listens})
        time.sleep(0.2)  # for what it might open beside them
        return sockets_of(folder)
    finally:
        process.kill()
        process.wait()


def test_z9_the_bus_as_it_is_without_a_configuration_is_on_loopback_alone(tmp_path) -> None:
    port = free_port()
    file = tmp_path / "robot.toml"
    file.write_text(f'[bus]\nlisten = ["tcp/127.0.0.1:{port}"]\n')  # the usual one, on a port that is free
    opened = opened_by(["bus", "--config", str(file)], [port])
    assert all(each.protocol == "tcp" and each.is_loopback for each in opened)
    assert {each.port for each in opened if each.listens} == {port}


def test_z9_a_bus_with_keys_listens_on_the_network_by_tls_alone(tmp_path) -> None:
    keys, tcp, tls = make_keys(tmp_path / "keys"), free_port(), free_port()
    listen = [f"tcp/127.0.0.1:{tcp}", f"tls/0.0.0.0:{tls}"]
    file = tmp_path / "robot.toml"
    file.write_text(f'[bus]\nkeys = "{keys / "robot"}"\nlisten = {listen}\n')
    opened = opened_by(["bus", "--config", str(file)], [tcp, tls])
    assert exposures(opened, listen) == []
    assert {each.port for each in opened if each.listens and not each.is_loopback} == {tls}
