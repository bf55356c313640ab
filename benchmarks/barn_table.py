# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The table of the BARN runs: shares, times, clearances, score, and under which conditions."""

from __future__ import annotations

import math
from statistics import mean, median
from typing import Any, Mapping, Sequence

from benchmarks.nav_run import Outcome

from edgefusion.config import BaseConfig
from edgefusion.sim.plan_simulation import PlanSpec

Record = Mapping[str, Any]

HEADER = (
    "field",
    "variant",
    "speed",
    "turning",
    "accelerations",
    "beams",
    "worlds",
    "success",
    "collision",
    "stuck",
    "time, mean / median",
    "clearance, least / median",
    "score",
)


def row(field: str, variant: str, base: BaseConfig, spec: PlanSpec, runs: Sequence[Record]) -> dict[str, Any]:
    """Conditions and figures of one setup's runs; times are of those that got there, NaN where none did."""
    reached = [run for run in runs if run["outcome"] == Outcome.REACHED.value]
    collided = sum(run["outcome"] in (Outcome.CONTACT.value, Outcome.WALKED_INTO.value) for run in runs)
    times_s = [run["time_s"] for run in reached] or [math.nan]
    return {
        "field": field,
        "variant": variant,
        "speed_mps": base.max_speed_mps,
        "yaw_rate_radps": base.max_yaw_rate_radps,
        "acceleration_mps2": base.acceleration_mps2,
        "yaw_acceleration_radps2": base.yaw_acceleration_radps2,
        "beams": spec.laser.beams,
        "field_of_view_deg": round(math.degrees(spec.laser.angle_increment) * (spec.laser.beams - 1)),
        "worlds": len(runs),
        "success": len(reached) / len(runs),
        "collision": collided / len(runs),
        "stuck": (len(runs) - len(reached) - collided) / len(runs),
        "time_mean_s": mean(times_s),
        "time_median_s": median(times_s),
        "clearance_least_m": min(run["clearance_m"] for run in runs),
        "clearance_median_m": median(run["clearance_m"] for run in runs),
        "score": mean(run["score"] for run in runs),
    }


def cells(row: Record) -> list[str]:
    """A row as text."""
    return [
        row["field"],
        row["variant"],
        f"{row['speed_mps']:.1f} m/s",
        f"{row['yaw_rate_radps']:.3g} rad/s",
        f"{row['acceleration_mps2']:g} m/s^2, {row['yaw_acceleration_radps2']:.3g} rad/s^2",
        f"{row['beams']} over {row['field_of_view_deg']} deg",
        str(row["worlds"]),
        *(f"{100 * row[name]:.1f} %" for name in ("success", "collision", "stuck")),
        f"{row['time_mean_s']:.1f} / {row['time_median_s']:.1f} s" if row["success"] else "-",
        f"{1000 * row['clearance_least_m']:.0f} / {1000 * row['clearance_median_m']:.0f} mm",
        f"{row['score']:.4f}",
    ]
