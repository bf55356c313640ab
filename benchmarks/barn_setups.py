# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is driven through the worlds of BARN: a Jackal with either field, and variants of the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Literal, Sequence, Tuple

from benchmarks.barn_worlds import Index
from benchmarks.nav_run import plan_spec

from edgefusion.config import BaseConfig
from edgefusion.errors import RefusedError
from edgefusion.sim.hull import Hull
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.plan_simulation import PlanSpec

Field = Literal["navigation-function", "khatib"]
FIELDS: Tuple[Field, ...] = ("navigation-function", "khatib")
VARIANTS = ("p3dx", "odometry", "delay")

JACKAL_LASER = LaserSpec(
    541, -math.radians(135), math.radians(0.5), 30.0, dropped=0.0, mixed=0.0, interlaced=False, turn_ns=25_000_000
)
JACKAL_LASER_POSE = (0.12, 0.0, 0.0)
P3DX_LASER = LaserSpec(dropped=0.0, mixed=0.0)


@dataclass(frozen=True)
class Setup:
    """What is driven in every world."""

    field: Field
    variant: str
    base: BaseConfig
    spec: PlanSpec


def jackal(index: Index, speed_mps: float, delay_s: float = 0.0) -> BaseConfig:
    """With the index's footprint, and its laser ahead of the middle, as the robot of the challenge has it."""
    corners = Hull(index.footprint).corners_m.tolist()
    return BaseConfig(
        footprint_m=tuple((x, y) for x, y in corners),
        laser_pose=JACKAL_LASER_POSE,
        max_speed_mps=speed_mps,
        max_yaw_rate_radps=3.0,
        acceleration_mps2=4.0,
        yaw_acceleration_radps2=12.0,
        command_delay_s=delay_s,
    )


def setups(index: Index, fields: Sequence[Field], speeds: Sequence[float], variants: Sequence[str]) -> List[Setup]:
    """The rows of the table: the fields at the speeds, then the variants at 1.0 m/s.

    Raises RefusedError where that is nothing, for a speed that no base has, and for an index's impossible footprint.
    """
    bases = [jackal(index, speed_mps) for speed_mps in speeds]
    plain = [Setup(field, "-", base, _jackal_spec(base)) for field in fields for base in bases]
    rows = plain + [_variant(index, name) for name in variants]
    if not rows:
        raise RefusedError("--fields, --speeds, --variants: expected something to drive, got none")
    return rows


def _jackal_spec(base: BaseConfig, percent: float = 0.0) -> PlanSpec:
    return plan_spec(base, JACKAL_LASER, percent, scan_period_ns=25_000_000, line_ns=5_000_000)


def _variant(index: Index, name: str) -> Setup:
    if name == "p3dx":
        base = BaseConfig(max_speed_mps=1.0, command_delay_s=0.0)
        return Setup(FIELDS[0], "P3-DX", base, plan_spec(base, P3DX_LASER, scan_period_ns=26_666_666))
    if name == "odometry":
        base = jackal(index, 1.0)
        return Setup(FIELDS[0], "odometry 2 % short", base, _jackal_spec(base, 2.0))
    base = jackal(index, 1.0, 0.2)
    return Setup(FIELDS[0], "commands 0.2 s late", base, _jackal_spec(base))
