# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""R1, R2, R6, R9: a robot's line that breaks, falls silent, is not read, or is wanted by somebody else too."""

from __future__ import annotations

from pathlib import Path
from typing import Optional

import pytest

from edgefusion.config import BaseConfig, PioneerConfig
from edgefusion.drivers.link import Link
from edgefusion.drivers.pioneer import Pioneer
from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.drivers.sip_command import Command
from edgefusion.sim.fault_frames import SIP
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import KINDS, Fault
from edgefusion.sim.wire_device import WireDevice
from pioneer_scenes import packets
from robot_faults import AHEAD, MS, SEEDS, Driven, MakeDriven, S, driven

__all__ = ["driven"]
REPORT_BYTES = 55
"""Of the simulated robot's, with two or three sonars."""


class Listening:
    """A wire device that notes when it said something last."""

    def __init__(self, device: WireDevice) -> None:
        self._device, self.said_ns = device, 0

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        self._device.receive(data, baudrate, now_ns)

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        data = self._device.transmit(baudrate, now_ns)
        self.said_ns = now_ns if data else self.said_ns
        return data


def in_mid_packet(made: Driven) -> bool:
    return not made.driver.line.reader.finder.is_between_packets


@pytest.mark.parametrize("seed", SEEDS)
def test_r1_unplugged_in_mid_packet_it_is_lost_at_once_found_again_and_stays(driven: MakeDriven, seed: int) -> None:
    made = driven(seed)
    made.until(lambda: in_mid_packet(made), 1, AHEAD)
    made.line.plugged = False
    assert made.until(lambda: made.is_lost and made.has_failed, 1, AHEAD) <= 0.1
    made.for_s(0.2 + 2 * made.rng.random())
    plugged_ns, made.line.plugged = made.clock(), True
    made.until(lambda: not made.is_lost, 5)
    first_ns, first = next((ns, data) for ns, data in made.line.written if ns >= plugged_ns)
    assert first_ns - plugged_ns <= 1 * S
    assert packets(first)[0][0] == Command.STOP
    where = made.robot.body.odometry
    made.for_s(1)
    assert made.moved_since(plugged_ns) == []
    assert made.robot.body.odometry == where


@pytest.mark.parametrize("offset", range(REPORT_BYTES + 1))
def test_r2_silent_after_any_number_of_bytes_it_is_lost_within_300_ms(driven: MakeDriven, offset: int) -> None:
    made = driven(offset)
    fault = FaultyWire(made.robot, SIP, Fault("robot", "off", float(offset)), made.rng, made.clock())
    made.line.device = listening = Listening(fault)
    listening.said_ns = made.clock()
    made.until(lambda: made.is_lost, 1, AHEAD)
    assert made.clock() - listening.said_ns <= 300 * MS
    assert made.has_failed


@pytest.mark.parametrize("seed", SEEDS)
def test_r6_a_robot_that_does_not_read_is_lost_after_the_writes_deadline(driven: MakeDriven, seed: int) -> None:
    made = driven(seed)
    made.line.blocked = True
    assert made.until(lambda: made.is_lost and made.has_failed, 1, AHEAD) <= 0.15
    assert "took no bytes for 0.1 s" in made.thread.news.health.reason


@pytest.mark.parametrize("seed", SEEDS)
def test_r9_a_second_instance_is_refused_and_the_first_loses_nothing(
    driven: MakeDriven, seed: int, tmp_path: Path
) -> None:
    made = driven(seed)
    written, openings, begun_ns = len(made.line.written), made.line.openings, made.clock()
    second = Pioneer(Link(made.link.name, 9600, lock_folder=tmp_path), PioneerConfig(), BaseConfig(), made.clock)
    with pytest.raises(PortBusyError, match=r"expected a free port, it is held by edgefusion \(pid \d+\)"):
        second.start()
    assert (made.clock(), made.line.openings, len(made.line.written)) == (begun_ns, openings, written)
    stamps = [state.stamp_ns for state in made.run(3.0, AHEAD)]
    assert len(stamps) == pytest.approx(30, abs=1)
    assert max(after - before for before, after in zip(stamps, stamps[1:])) < 0.12 * S


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_after_any_fault_of_its_line_it_reports_again_and_nothing_has_died(
    driven: MakeDriven, seed: int, kind: str
) -> None:
    made = driven(seed)
    fault = Fault("robot", kind, KINDS[kind][0], 0.0, 2.0)
    made.line.device = FaultyWire(made.robot, SIP, fault, made.rng, made.clock())
    made.for_s(2.0, AHEAD)
    made.until(lambda: not made.is_lost, 5)
    made.for_s(1.0)
    assert not made.is_lost
    assert len(made.run(1.0)) == pytest.approx(10, abs=1)
