# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A robot's drive over a line whose bytes are noise now and then: what of it comes to navigation."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Deque

import numpy as np

from edgefusion.config import BaseConfig, PioneerConfig
from edgefusion.drivers.pioneer_factors import HALF_WHEEL_BASE, factors_for
from edgefusion.drivers.pioneer_limits import limits_of
from edgefusion.drivers.pioneer_reports import Reports
from edgefusion.drivers.sip import SipReader
from edgefusion.drivers.sip_status import Status, read_status
from edgefusion.sim.sip_robot_packets import status as sip
from edgefusion.types import STILL, Pose2D, Twist2D

CYCLE_NS = 100_000_000
_CYCLE_S, _KEEPS = 0.1, 20
_FAR_M, _TURNED, _FASTER_MPS, _FASTER_RADPS = 0.3, math.radians(30), 1.0, 2.0
"""A state that is off by more than one of these is implausible: in a cycle no robot gets so far, or so much faster."""


@dataclass
class NoisyDrive:
    """intact: packets of which no byte was noise; kept: those of them that came through. implausible: states that did,
    and are far from the truth. off_m: how far off the pose is that the last intact packet led to."""

    intact: int = 0
    kept: int = 0
    implausible: int = 0
    off_m: float = 0.0


class _Robot:
    """Drives about at random, as a Pioneer can."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self.pose, self.twist, self._wanted = STILL, Twist2D(), Twist2D()

    def step(self) -> bytes:
        """A cycle; what it reports then."""
        if self._rng.random() < 0.05:
            self._wanted = Twist2D(self._rng.uniform(-0.5, 0.5), self._rng.uniform(-1.0, 1.0))
        v = self.twist.v_mps + float(np.clip(self._wanted.v_mps - self.twist.v_mps, -0.03, 0.03))
        w = self.twist.w_radps + float(np.clip(self._wanted.w_radps - self.twist.w_radps, -0.17, 0.17))
        self.twist = Twist2D(v, w)
        self.pose = self.pose.compose(self.twist.motion(_CYCLE_S))
        aside = w / HALF_WHEEL_BASE
        wheels = round(v * 1e3 - aside), round(v * 1e3 + aside)
        place = round(self.pose.x_m * 1e3) & 0x7FFF, round(self.pose.y_m * 1e3) & 0x7FFF
        heading = round(self.pose.theta * 4096 / (2 * math.pi))
        sonars = [(int(n), int(self._rng.integers(200, 5001))) for n in self._rng.choice(16, 3, replace=False)]
        turn_ddps = round(math.degrees(w) * 10)
        off = (False, False), (0, 0), True, False, True
        return sip((*place, heading), wheels, turn_ddps, 125, *off, sonars, (0, 0))


def noisy_drive(rng: np.random.Generator, packets: int, error: float) -> NoisyDrive:
    """error: the share of the bytes that are another. The first packet is intact: that is where the pose begins."""
    robot, reader, run = _Robot(rng), SipReader(), NoisyDrive()
    reports = Reports(PioneerConfig(), limits_of(BaseConfig(), None), factors_for("p3dx-sh", PioneerConfig()), STILL)
    waiting: Deque[Status] = deque(maxlen=_KEEPS)
    for cycle in range(packets):
        packet = robot.step()
        data = _with_noise(packet, error if cycle else 0.0, rng)
        if data == packet:
            run.intact += 1
            waiting.append(read_status(packet[3:-2]))
        # Between two packets a line of 38400 baud is silent for so long that the driver gives an unfinished one up.
        for message in reader.feed(data) + reader.give_up():
            if isinstance(message, Status):
                _judge(run, reports, message, cycle * CYCLE_NS, robot, waiting)
    return run


def _judge(
    run: NoisyDrive, reports: Reports, message: Status, stamp_ns: int, robot: _Robot, waiting: Deque[Status]
) -> None:
    state = reports.add(stamp_ns, message, None)
    if state is None:
        return
    if message in waiting:
        waiting.remove(message)
        run.kept += 1
        run.off_m = _way_m(state.odometry, robot.pose)
    run.implausible += _is_far(state.odometry, robot.pose) or _is_other(state.twist, robot.twist)


def _way_m(pose: Pose2D, truth: Pose2D) -> float:
    return math.dist((pose.x_m, pose.y_m), (truth.x_m, truth.y_m))


def _is_far(pose: Pose2D, truth: Pose2D) -> bool:
    return _way_m(pose, truth) > _FAR_M or abs(math.remainder(pose.theta - truth.theta, 2 * math.pi)) > _TURNED


def _is_other(twist: Twist2D, truth: Twist2D) -> bool:
    return abs(twist.v_mps - truth.v_mps) > _FASTER_MPS or abs(twist.w_radps - truth.w_radps) > _FASTER_RADPS


def _with_noise(packet: bytes, error: float, rng: np.random.Generator) -> bytes:
    data = np.frombuffer(packet, np.uint8).copy()
    hit = rng.random(len(data)) < error
    data[hit] ^= rng.integers(1, 256, int(hit.sum()), dtype=np.uint8)
    return data.tobytes()
