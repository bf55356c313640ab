# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the detector."""

from __future__ import annotations

import sys
from typing import Literal, Optional, Tuple

import msgspec

from edgefusion.config.strict import Seconds, Share, UpTo1, UpTo10, UpTo100, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

Heights = Annotated[Tuple[UpTo100, ...], msgspec.Meta(min_length=1, max_length=16)]
HeightRule = Literal["paper", "weighted", "sharpened"]

USUAL_HEIGHTS = (0.4, 1.0, 2.5)
"""In widths. They span the middle 90 % of 58 objects in photographs and named more of them than 0.6, 1.0, 1.6
(BENCHMARKS.md)."""


class PerceptionConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the detector clusters, boxes, votes and measures. The defaults suit a 0.5 degree laser on a robot."""

    # DBSCAN: on {X, Y}, or on the paper's {Y, r}, which is singular at the sides.
    features: Literal["xy", "yr"] = "xy"
    eps_m: UpTo10 = 0.3
    min_points: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 3
    # Part an object from the wall that it stands at, or from a deeper one beside it; the paper does not.
    split: bool = True
    # Wider clusters are walls: background, never named. So are those wider than max_flush_width_m of which an end does
    # not stand out from what is beside it, as a car's do.
    max_object_width_m: UpTo100 = 5.0
    max_flush_width_m: UpTo100 = 3.0
    # The nearest clusters that project into the image; the paper takes 1.
    objects: Annotated[int, msgspec.Meta(ge=1, le=100)] = 8

    # Candidate boxes: heights as pixel height / pixel width, or in metres above the bottom edge. None: those that the
    # model was trained to tell apart, else USUAL_HEIGHTS.
    heights: Optional[Heights] = None
    heights_in: Literal["widths", "metres"] = "widths"
    # Box k is 1 + k * width_step times as wide as the cluster.
    width_step: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.0
    # How far beyond its last beam a cluster is taken to go, in steps to the next: half a step on average, and a quarter
    # more since a beam that lies on two surfaces reads something between and is lost to the cluster.
    margin_steps: UpTo10 = 0.75
    bottom: Literal["ground", "scan"] = "ground"
    # A box of which less than this share of its area lies in the image is dropped.
    min_visible: UpTo1 = 0.25

    # The vote, and when its winner is too weak to be named. height_rule None: what the model was trained for, else the
    # paper's.
    height_rule: Optional[HeightRule] = None
    min_score: Share = 0.05
    min_margin: Share = 0.0

    # Distance: the nearest range corrected for the noise of the beams, or the paper's min(r).
    distance: Literal["corrected", "minimum"] = "corrected"
    range_sigma_m: UpTo1 = 0.01

    def __post_init__(self) -> None:
        check_fields(self)
        if self.heights is None and self.heights_in != "widths":
            raise RefusedError(f"heights_in: expected heights beside {self.heights_in}, got none")


class SyncConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How scans and frames are paired by their stamps."""

    tolerance_s: Seconds = 0.1
    horizon_s: Seconds = 1.0

    def __post_init__(self) -> None:
        check_fields(self)
        if self.tolerance_s > self.horizon_s:
            raise RefusedError(f"tolerance_s: expected at most horizon_s, {self.horizon_s:g}, got {self.tolerance_s:g}")
