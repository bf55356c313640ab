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

    features: Literal["xy", "yr"] = "xy"
    """DBSCAN: on {X, Y}, or on the paper's {Y, r}, which is singular at the sides."""
    eps_m: UpTo10 = 0.3
    """DBSCAN: points no farther apart are neighbours."""
    min_points: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 3
    """DBSCAN: so many neighbours make a cluster. [beams]"""
    split: bool = True
    """Part an object from the wall that it stands at, or from a deeper one beside it; the paper does not."""
    max_object_width_m: UpTo100 = 5.0
    """Wider clusters are walls: background, never named."""
    max_flush_width_m: UpTo100 = 3.0
    """Walls, too, are clusters wider than this of which an end does not stand out from what is beside it, as a car's
    do."""
    objects: Annotated[int, msgspec.Meta(ge=1, le=100)] = 8
    """So many of the nearest clusters that project into the image; the paper takes 1. [clusters]"""

    heights: Optional[Heights] = None
    """Of the candidate boxes. Left out: those that the model was trained to tell apart, else 0.4, 1.0 and 2.5 widths.
    [widths or m]"""
    heights_in: Literal["widths", "metres"] = "widths"
    """heights are pixel height / pixel width, or metres above the bottom edge; metres only beside heights."""
    width_step: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.0
    """Box k is 1 + k * width_step times as wide as the cluster. [widths]"""
    margin_steps: UpTo10 = 0.75
    """How far beyond its last beam a cluster is taken to go, in steps to the next: half a step on average, and a
    quarter more since a beam that lies on two surfaces reads something between and is lost to the cluster. [steps]"""
    bottom: Literal["ground", "scan"] = "ground"
    """Boxes stand on the ground, or on the scan's line."""
    min_visible: UpTo1 = 0.25
    """A box of which less than this share of its area lies in the image is dropped. [share]"""

    height_rule: Optional[HeightRule] = None
    """How the boxes vote: the paper's, or by the mean of the boxes, weighted by the winner's probability, or
    "sharpened" by its eighth power. Left out: what the model was trained for, else the paper's."""
    min_score: Share = 0.05
    """A weaker winner is "unknown". [share]"""
    min_margin: Share = 0.0
    """A winner that is nearer to the second is "unknown". [share]"""

    distance: Literal["corrected", "minimum"] = "corrected"
    """The nearest range corrected for the noise of the beams, or the paper's min(r)."""
    range_sigma_m: UpTo1 = 0.01
    """Noise of one beam: 10 mm for an LMS2xx."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.heights is None and self.heights_in != "widths":
            raise RefusedError(f"heights_in: expected heights beside {self.heights_in}, got none")


class SyncConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How scans and frames are paired by their stamps."""

    tolerance_s: Seconds = 0.1
    """Between the stamps of a scan and its frame; at most horizon_s."""
    horizon_s: Seconds = 1.0
    """How long one waits for the other."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.tolerance_s > self.horizon_s:
            raise RefusedError(f"tolerance_s: expected at most horizon_s, {self.horizon_s:g}, got {self.tolerance_s:g}")
