# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The few data types that everything exchanges. Frozen; arrays are read-only; RefusedError where none can be made.

Stamps are nanoseconds of the monotonic clock of the robot's computer. Frames as in ROS REP 103/105: `odom`,
`base_link` and `laser` (x forward, y left, z up), `camera_optical` (z forward, x right, y down). Angles in
radians, counter-clockwise positive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple, Tuple, TypeVar

import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError

Scalar = TypeVar("Scalar", bound=np.generic)

Box = Tuple[int, int, int, int]
"""(x0, y0, x1, y1) in pixels, x1 and y1 exclusive, always inside the image."""

UNKNOWN = "unknown"
"""The label of an object that the classifier cannot name."""

BACKGROUND = "background"
"""A classifier's class of this label stands for all that is none of its others: it is published as UNKNOWN."""


def read_only(array: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    """A read-only view of an array."""
    view = array.view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True)
class Scan:
    """One sweep of the laser, in its own frame.

    stamp_ns: when the middle beam was measured. ranges_m: float32[n]; +inf = free up to range_max_m, -inf = an
    obstacle nearer than range_min_m, NaN = unknown (REP 117). beam_dt_ns: int64[n], per-beam offsets from stamp_ns, or
    None.
    """

    stamp_ns: int
    ranges_m: npt.NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_min_m: float = 0.0
    range_max_m: float = math.inf
    beam_dt_ns: npt.NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        ranges_m = np.asarray(self.ranges_m, np.float32)
        if ranges_m.ndim != 1:
            raise RefusedError(f"ranges_m: expected shape [n], got {list(ranges_m.shape)}")
        if not (math.isfinite(self.angle_min) and math.isfinite(self.angle_increment)):
            raise RefusedError(f"angles: expected finite values, got {self.angle_min} and {self.angle_increment}")
        if not 0 <= self.range_min_m < math.inf:
            raise RefusedError(f"range_min_m: expected a finite number of at least 0, got {self.range_min_m}")
        if not self.range_max_m > self.range_min_m:
            raise RefusedError(f"range_max_m: expected above range_min_m, {self.range_min_m}, got {self.range_max_m}")
        object.__setattr__(self, "ranges_m", read_only(ranges_m))
        if self.beam_dt_ns is not None:
            dt_ns = np.asarray(self.beam_dt_ns, np.int64)
            if dt_ns.shape != ranges_m.shape:
                raise RefusedError(f"beam_dt_ns: expected shape {list(ranges_m.shape)}, got {list(dt_ns.shape)}")
            object.__setattr__(self, "beam_dt_ns", read_only(dt_ns))

    @property
    def angles(self) -> npt.NDArray[np.float64]:
        """Direction of every beam, float64[n]."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges_m), dtype=np.float64)


@dataclass(frozen=True)
class Frame:
    """One image of the camera, BGR uint8 [height, width, 3], stamped when it was captured."""

    stamp_ns: int
    image: npt.NDArray[np.uint8]

    def __post_init__(self) -> None:
        if self.image.dtype != np.uint8 or self.image.ndim != 3 or self.image.shape[2] != 3:
            raise RefusedError(
                f"image: expected uint8 [height, width, 3], got {self.image.dtype} {list(self.image.shape)}"
            )
        object.__setattr__(self, "image", read_only(self.image))


@dataclass(frozen=True)
class Pose2D:
    """A pose, or a motion, in the plane."""

    x_m: float = 0.0
    y_m: float = 0.0
    theta: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x_m) and math.isfinite(self.y_m) and math.isfinite(self.theta)):
            raise RefusedError(f"pose: expected finite values, got ({self.x_m}, {self.y_m}, {self.theta})")

    def matrix(self) -> npt.NDArray[np.float64]:
        """The transform [4, 4] that maps coordinates of this pose's frame into its parent's."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return np.array([[c, -s, 0, self.x_m], [s, c, 0, self.y_m], [0, 0, 1, 0], [0, 0, 0, 1]], float)

    def compose(self, inner: Pose2D) -> Pose2D:
        """A pose given in this pose's frame, in this pose's parent."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        x_m = self.x_m + c * inner.x_m - s * inner.y_m
        return Pose2D(x_m, self.y_m + s * inner.x_m + c * inner.y_m, _wrapped(self.theta + inner.theta))

    def relative_to(self, origin: Pose2D) -> Pose2D:
        """This pose in the frame of another one of the same parent: origin.compose(it) is this pose."""
        c, s = math.cos(origin.theta), math.sin(origin.theta)
        dx, dy = self.x_m - origin.x_m, self.y_m - origin.y_m
        return Pose2D(c * dx + s * dy, c * dy - s * dx, _wrapped(self.theta - origin.theta))


def _wrapped(angle: float) -> float:
    """The same direction in [-pi, pi]."""
    return math.remainder(angle, 2 * math.pi)


@dataclass(frozen=True)
class Twist2D:
    """A velocity in the plane, in base_link: forward [m/s] and about the vertical [rad/s], left positive."""

    v_mps: float = 0.0
    w_radps: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.v_mps) and math.isfinite(self.w_radps)):
            raise RefusedError(f"twist: expected finite values, got ({self.v_mps}, {self.w_radps})")

    def motion(self, duration_s: float) -> Pose2D:
        """Where this velocity leads to, in the frame that it starts from: an arc, exactly. Also backwards in time."""
        half_turn, way_m = self.w_radps * duration_s / 2, self.v_mps * duration_s
        chord_m = way_m * (math.sin(half_turn) / half_turn) if half_turn else way_m
        return Pose2D(chord_m * math.cos(half_turn), chord_m * math.sin(half_turn), _wrapped(2 * half_turn))


MOST_TOLERANCE_M = 100.0
"""Of a goal's place: who is content farther off has no goal."""

FARTHEST_M = 5e4
"""From the origin of `odom`, along either axis, nobody drives: navigation's maps reach twice as far."""


@dataclass(frozen=True)
class Goal:
    """Where to drive to, in `odom`. id: names it in what is reported about it.

    position_tolerance_m, heading_tolerance [rad]: how near to the pose is arrived; a tolerance of pi: any heading.
    """

    id: str
    pose: Pose2D
    position_tolerance_m: float = 0.05
    heading_tolerance: float = math.radians(3)

    def __post_init__(self) -> None:
        for name in ("position_tolerance_m", "heading_tolerance"):
            if not 0 < getattr(self, name) < math.inf:
                raise RefusedError(f"{name}: expected a finite number above 0, got {getattr(self, name)}")
        if self.position_tolerance_m > MOST_TOLERANCE_M:
            raise RefusedError(
                f"position_tolerance_m: expected at most {MOST_TOLERANCE_M:g}, got {self.position_tolerance_m:g}"
            )
        if max(abs(self.pose.x_m), abs(self.pose.y_m)) > FARTHEST_M:
            raise RefusedError(f"goal {self.id}: expected coordinates up to {FARTHEST_M:g} m, got {self.pose}")


class HealthState(str, Enum):
    """STARTING: not ready yet, as at boot. DEGRADED: works, but not as well as it should."""

    OK = "ok"
    STARTING = "starting"
    DEGRADED = "degraded"
    FAILED = "failed"


@dataclass(frozen=True)
class Health:
    """How a component is, and why, in the words that log and viewer show: only one that is well needs no reason."""

    component: str
    state: HealthState
    reason: str = ""

    def __post_init__(self) -> None:
        if not self.component:
            raise RefusedError("component: expected a name, got none")
        if self.state is not HealthState.OK and not self.reason:
            raise RefusedError(f"reason: expected why {self.component} is {self.state.value}, got none")


STILL = Pose2D()
"""The motion of a robot that stood still, or whose odometry is unknown."""


@dataclass(frozen=True)
class Cluster:
    """Neighbouring beams that hit one thing. indices: int64[m] into the scan, rising."""

    indices: npt.NDArray[np.int64]
    range_m: float
    bearing: float
    width_m: float


class ClassScore(NamedTuple):
    """One class of the classifier and the probability or score it got."""

    class_index: int
    label: str
    score: float


@dataclass(frozen=True)
class Vote:
    """The vote over the candidate boxes of one object, as published.

    ranking: every class in some box's top 5, best first. box_index: the box that gave the winner its highest
    probability. margin: lead of the winner over the second. top5: the best five of each box.
    """

    ranking: tuple[ClassScore, ...]
    box_index: int
    margin: float
    top5: tuple[tuple[ClassScore, ...], ...]

    @property
    def winner(self) -> ClassScore:
        return self.ranking[0]


@dataclass(frozen=True)
class Detection:
    """One object: what it is, where it is in the image and how far away.

    stamp_ns: the frame's capture. label: UNKNOWN where the vote was too weak; group: the label's group or "".
    class_index and score stay the winner's then. distance_m: range from the laser's origin to the object's nearest
    surface, with its 1-sigma; bearing: its direction from there in base_link's axes, left positive; position_m: that
    nearest point in base_link (x, y). All three at stamp_ns.
    scan_frame_dt_ns: the frame's stamp minus the scan's; motion: the robot's motion in between, motion_px what it
    moved the object by in the image, NaN where the camera sees only one of the two places. boxes: every candidate
    box, in the order of vote.top5. cluster: its beams.
    """

    stamp_ns: int
    class_index: int
    label: str
    group: str
    score: float
    margin: float
    box: Box
    distance_m: float
    distance_sigma_m: float
    bearing: float
    position_m: tuple[float, float]
    vote: Vote
    boxes: tuple[Box, ...]
    cluster: Cluster
    scan_frame_dt_ns: int
    motion: Pose2D = field(default=STILL)
    motion_px: float = 0.0
