# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of the bus against the processes that a robot runs: Z2 and Z9; how long it takes is `make faults`'s matter."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Iterator, List

import pytest

from base_lab import wait_for
from bus_lab import free_port, make_keys
from bus_robot import BusRobot
from edgefusion.bus.session import open_client
from edgefusion.errors import RefusedError
from edgefusion.tools.doctor_bus import exposures
from edgefusion.tools.doctor_sockets import Socket, sockets_of

HANDLES = 256

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


def resumes(robot) -> bool:
    with suppress(RefusedError, ConnectionError):
        robot.resume()
        return True
    return False


def test_z2_an_operator_who_is_required_and_halted_stops_the_robot_which_stays_also_when_he_goes_on(tmp_path) -> None:
    with BusRobot(tmp_path, "require_operator = true") as it:
        robot = it.start("bus", "base").connect()
        operator = subprocess.Popen([sys.executable, "-c", ATTENDS, it.endpoint])
        it.processes["operator"] = operator
        wait_for(lambda: sets_off(it, robot))
        operator.send_signal(signal.SIGSTOP)
        since_ns = time.monotonic_ns()
        assert it.stopped_after_s(since_ns) < 10.0  # 0.5 s and a cycle on a machine with nothing else to do
        wait_for(lambda: robot.status.mission.reason == "no heartbeat of an operator for 0.5 s")
        with pytest.raises(RefusedError, match="no heartbeat"):
            robot.resume()
        stood_ns = time.monotonic_ns()
        operator.send_signal(signal.SIGCONT)
        time.sleep(0.5)
        assert it.velocities(stood_ns) <= {0}
        wait_for(lambda: resumes(robot))  # once he is there again, who was halted for longer than a lease, perhaps
        wait_for(lambda: sets_off(it, robot))


class Bus:
    """`edgefusion bus` with few handles at first; it listens when this returns."""

    def __init__(self, folder: Path, listen: List[str], further: str = "") -> None:
        self.listen = listen
        file = folder / "robot.toml"
        file.write_text(f"[bus]\nlisten = {listen}\n{further}\n")
        argv = ["sh", "-c", f'ulimit -Sn {HANDLES}; exec "$@"', "sh", sys.executable, "-m", "edgefusion.cli", "bus"]
        self.process = subprocess.Popen([*argv, "--config", str(file)])
        ports = {int(each.rsplit(":", 1)[1]) for each in listen}
        wait_for(lambda: ports <= {each.port for each in self.sockets if each.listens})

    @property
    def sockets(self) -> List[Socket]:
        return sockets_of(Path(f"/proc/{self.process.pid}"))

    def end(self) -> None:
        self.process.kill()
        self.process.wait()


@pytest.fixture(scope="module")
def usual_bus(tmp_path_factory) -> Iterator[Bus]:
    """As it is without a configuration, but for its port, which is one that is free."""
    bus = Bus(tmp_path_factory.mktemp("bus"), [f"tcp/127.0.0.1:{free_port()}"])
    yield bus
    bus.end()


@pytest.fixture(scope="module")
def keyed_bus(tmp_path_factory) -> Iterator[Bus]:
    keys = make_keys(tmp_path_factory.mktemp("keys") / "keys")
    listen = [f"tcp/127.0.0.1:{free_port()}", f"tls/0.0.0.0:{free_port()}"]
    bus = Bus(tmp_path_factory.mktemp("bus"), listen, f'keys = "{keys / "robot"}"')
    yield bus
    bus.end()


def test_z9_the_bus_as_it_is_without_a_configuration_is_on_loopback_alone(usual_bus: Bus) -> None:
    time.sleep(0.2)  # for what it might open beside its listener
    assert all(each.protocol == "tcp" and each.is_loopback for each in usual_bus.sockets)
    assert len([each for each in usual_bus.sockets if each.listens]) == 1


def test_z9_a_bus_with_keys_listens_on_the_network_by_tls_alone(keyed_bus: Bus) -> None:
    time.sleep(0.2)
    assert exposures(keyed_bus.sockets, keyed_bus.listen) == []
    assert len([each for each in keyed_bus.sockets if each.listens and not each.is_loopback]) == 1


def test_who_connects_without_keys_and_says_nothing_keeps_nobody_out(keyed_bus: Bus) -> None:
    loopback, network = (each.rsplit(":", 1)[1] for each in keyed_bus.listen)
    with ExitStack() as stack:
        for _ in range(HANDLES + 50):
            stack.enter_context(socket.create_connection(("127.0.0.1", int(network)), 5))
        with open_client(f"tcp/127.0.0.1:{loopback}", timeout_s=20):
            pass
