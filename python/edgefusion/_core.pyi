"""The C++ core. What may take milliseconds releases the GIL: every function but `followed`, and of the classes
NavigationFunction.begin and .advance and Manoeuvre.advance; the rest takes microseconds. No object may be used by two
threads at once.

Numbers may come in arrays of any real type; boxes in arrays of any integer type, since they are never rounded; an
image is never converted. Anything else raises ValueError, one line that names the argument.
"""

from typing import Any, Final, Literal, Optional, Sequence, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

_Numbers = Union[npt.NDArray[np.floating[Any]], npt.NDArray[np.integer[Any]]]
_Floats = Union[_Numbers, Sequence[Sequence[float]]]
_Vector = Union[_Numbers, Sequence[float]]
_Boxes = Union[npt.NDArray[np.integer[Any]], Sequence[Sequence[int]]]
_Fit = Literal["squash", "letterbox", "square-context", "shorter-side+centre"]
_Filter = Literal["antialias", "linear"]

VISIBLE: Final[int]
"""Mark of a point in front of the camera; its pixel may still lie outside the image."""
BEHIND: Final[int]
"""Mark of a point on or behind the camera's plane."""
BEYOND: Final[int]
"""Mark of a point so far off axis that the distortion folds back, or overflows."""

def dbscan(points: _Floats, eps: float, min_points: int) -> npt.NDArray[np.int32]:
    """DBSCAN of points [n, 2], in any unit; the labels int32[n] are those of scikit-learn's k-d tree, noise is -1.

    A point is a core point when at least `min_points` points, itself included, lie within `eps`: squared distances
    are compared, in doubles (its other algorithms may decide otherwise on a distance that rounding makes eps).
    Memory is linear in n; time is at most proportional to n * min_points, and linear unless points are crowded.
    Source: Ester et al., "A density-based algorithm for discovering clusters", KDD 1996.

    Raises ValueError for a coordinate that is not finite, eps <= 0 or min_points < 1.
    """

def split_clusters(
    points: _Floats, labels: npt.NDArray[np.signedinteger[Any]], sigma_m: float, eps: float, min_points: int
) -> npt.NDArray[np.int32]:
    """Clusters int32[n] in which something stands before a straight face, split: an object at a wall, or beside a
    deeper one.

    points [n, 2] in the laser's frame [m], in the order of the beams; labels [n] as `dbscan` gives them; sigma_m: the
    noise of a beam. A single object is convex as the laser sees it: no point is nearer than the line along one of its
    faces. Where some are, the face becomes a cluster, and the rest is clustered again by eps and min_points.
    A cluster keeps its label for one of its parts; the others get new ones.

    Raises ValueError for a coordinate that is not finite, a label that is none, sigma_m or eps <= 0, min_points < 1.
    """

class Camera:
    """OpenCV's camera: pinhole with radial, tangential, thin prism and tilt distortion."""

    def __init__(self, K: _Floats, distortion: Union[_Vector, _Floats] = ...) -> None:
        """K [3, 3] in pixels; 0, 4, 5, 8, 12 or 14 coefficients in OpenCV's order, [n], [1, n] or [n, 1].

        Raises ValueError for anything else, or a number that is not finite.
        """
    @property
    def max_radius(self) -> float:
        """Tangent of the angle off axis up to which the radial coefficients let the radius grow; may be inf."""

@overload
def project(
    points: _Floats, camera: Camera, T_camera_laser: _Floats
) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.uint8]]:
    """Pixels [n, 2] and marks [n] of points [n, 3] of the laser's frame [m]: eq. (1), p ~ K R [I | -t] P.

    T_camera_laser [4, 4] maps laser coordinates into camera coordinates (z forward, x right, y down).
    A point that is not VISIBLE has the pixel (NaN, NaN). BEYOND is beyond the camera's `max_radius`, or where all
    coefficients together turn the picture over.

    Raises ValueError for a point that is not finite, naming its row, or a last row of T_camera_laser other than
    [0, 0, 0, 1].
    """

@overload
def project(
    points: _Floats, K: _Floats, distortion: Union[_Vector, _Floats], T_camera_laser: _Floats
) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.uint8]]: ...
def project_paper(points: _Floats, K: _Floats, width: int, height: int) -> npt.NDArray[np.float64]:
    """Pixels [n, 2] by the paper's eqs. (2) and (3), from points [n, 3] in robot axes about the camera [m].

    Mirrors the principal point: equals `project` only for cx = width / 2 and cy = height / 2, without distortion.
    NaN where X <= 0. Raises ValueError for a point that is not finite, naming its row, or a K that is no camera's.
    """

def candidate_boxes(
    ranges_m: _Vector,
    angles_rad: _Vector,
    step_rad: float,
    camera: Camera,
    T_camera_laser: _Floats,
    to_ground: _Vector,
    width: int,
    height: int,
    heights: _Vector,
    heights_are_metric: bool = ...,
    width_step: float = ...,
    on_ground: bool = ...,
    min_visible: float = ...,
) -> Tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Candidate boxes int32[k, 4] of one cluster's beams, and the index int32[k] of the height each came from.

    A box is as wide as the beams, each taken half a step wider on either side (box i: 1 + i * width_step times
    that); its bottom edge is on the ground under the nearest beam (`to_ground`: from a laser point straight down,
    laser frame [m]) or on the scan line; its height is heights[i] metres, or heights[i] times its width in pixels.
    Clipped to the image; dropped where less than `min_visible` of its area would remain.

    No cluster raises, wherever it is. Raises ValueError for a range or an angle that is not finite, naming its index,
    no heights or one that is not above 0, step_rad <= 0, width_step < 0, min_visible outside (0, 1], a to_ground
    without length, width or height below 1, or a T_camera_laser as `project` does.
    """

def nearest_range(ranges_m: _Vector, sigma_m: float) -> Tuple[float, float, int]:
    """Range [m] of the nearest surface behind the ranges of neighbouring beams, its sigma [m], the nearest beam.

    The paper's min(r), corrected for the bias of a minimum over beams of noise `sigma_m` and for what lies between
    the beams. Raises ValueError for no ranges, one that is not finite, naming its index, or sigma_m <= 0.
    """

def raycast(
    segments: _Floats, pose: _Vector, angle_min: float, angle_increment: float, n: int, range_max: float
) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]:
    """Exact ranges float64[n] [m] of a 2D laser at pose (x, y, theta), and the rows int32[n] of what its beams hit.

    segments [m, 4]: (x0, y0, x1, y1) in the world [m]. Beam i points to theta + angle_min + i * angle_increment, over
    any part of a turn or several; where it meets nothing within range_max its range is +inf and its hit -1.
    No beam passes between two segments that share an end; of two that are equally near the lower row is hit. A
    segment without length is hit by no beam, one along a beam at its nearer end, one that the laser stands on at 0.

    Raises ValueError for a number that is not finite, naming its index, an angle_increment of 0, n < 0 or
    range_max <= 0.
    """

def crops(
    image: npt.NDArray[np.uint8],
    boxes: _Boxes,
    size: int,
    mean: _Vector,
    std: _Vector,
    fit: _Fit = ...,
    filter: _Filter = ...,
    crop_fraction: float = ...,
    out: Optional[npt.NDArray[np.float32]] = ...,
) -> npt.NDArray[np.float32]:
    """Boxes [n, 4] of a BGR image [h, w, 3] as RGB float32[n, 3, size, size], (value / 255 - mean) / std.

    fit: "squash" (the paper), "letterbox", "square-context" (the square around the box) or "shorter-side+centre"
    (shorter side to size / crop_fraction, then the centre, as torchvision does).
    filter: "antialias" (Pillow's BILINEAR, what torchvision does) or "linear" (OpenCV's INTER_LINEAR).
    out: a buffer to write into, returned.

    Raises ValueError for an empty box, one outside the image, boxes that are no integers, an image that is not uint8
    BGR or above 2^28 pixels a side, a wrong `out`.
    """

class Footprint:
    """The hull of a base seen from above: a convex polygon about the middle of its axle.

    corners_m: [n, 2] in base_link, in either sense. Raises ValueError for fewer than 3 corners, values that are not
    finite, a polygon that is not convex or does not hold the origin.
    """

    def __init__(self, corners_m: npt.ArrayLike) -> None: ...
    @property
    def inscribed_m(self) -> float:
        """Radius of the largest circle about the origin inside the hull."""
    @property
    def circumscribed_m(self) -> float:
        """Radius of the smallest circle about the origin around the hull."""
    def gap(self, x_m: float, y_m: float) -> float:
        """From the hull to a point in base_link, below 0 inside; near a corner less than the true one, never more."""

class ObstacleMap:
    """What the laser has seen so far, in cells; each remembers the mean of the points seen in it.

    Its window begins empty: what lies outside is not kept. Raises ValueError for a cell not above 0.
    """

    def __init__(self, cell_m: float) -> None: ...
    def cover(self, x_m: float, y_m: float, target_x_m: float, target_y_m: float) -> None:
        """Makes the window hold the base, and the target where both fit into 60 x 60 m, with 5 m around either."""
    def insert(
        self,
        poses: npt.ArrayLike,
        ranges_m: npt.ArrayLike,
        angle_min: float,
        angle_increment: float,
        range_min_m: float,
        range_max_m: float,
        stamp_ns: int,
    ) -> None:
        """Marks what beams ended at and lets fade what they came through. poses [n, 3]: the laser's (x, y, theta) in
        the map at each beam. ranges_m [n]: NaN unknown, +inf free, -inf nearer than range_min_m (REP 117)."""
    def ages(self, points_m: npt.ArrayLike, stamp_ns: int) -> npt.NDArray[np.float64]:
        """For how long something has been at points [n, 2] that were seen free before [s]; inf where it always was, as
        far as is known, and where nothing is."""
    def stand(self, footprint: Footprint, pose: npt.ArrayLike, inset_m: float) -> None:
        """Forgets what was seen where the base, at (x, y, theta), now stands, as far as inset_m inside its hull."""
    def avoid(self, x_m: float, y_m: float, radius_m: float) -> None:
        """The base failed to get through there: ways through that circle are longer from now on."""
    def points(self) -> npt.NDArray[np.float64]:
        """All points, float64[n, 2]."""
    def seen(self, x_m: float, y_m: float) -> bool:
        """Whether a beam, or the base, has ever come through there."""
    @property
    def window(self) -> tuple[int, int, int, int]:
        """(column, row, columns, rows): column c covers x from c * cell_m to (c + 1) * cell_m."""

class NavigationFunction:
    """A potential without local minima: the way to the goal [m], longer near obstacles, by fast marching.

    blocked_m: the base's middle never comes nearer to a point. comfort_m: from here on obstacles are of no account.
    weight: a metre right beside what is blocked counts 1 + weight. Raises ValueError for values that are not finite or
    below 0, and comfort_m not above blocked_m.
    """

    def __init__(self, blocked_m: float, comfort_m: float, weight: float) -> None: ...
    def begin(
        self, map: ObstacleMap, goal_x_m: float, goal_y_m: float, tolerance_m: float, x_m: float, y_m: float
    ) -> None:
        """Begins to compute it anew for a base at (x_m, y_m); the last one stays in use until then."""
    def advance(self, map: ObstacleMap, cells: int) -> bool:
        """Does so many cells' work; True when what was begun is done, and in use."""
    @property
    def running(self) -> bool:
        """Whether one was begun and is not done."""
    @property
    def outcome(self) -> str:
        """Of the one in use: "reached", "enclosed" (no way from the base) or "occupied" (no room at the goal)."""
    def value(self, x_m: float, y_m: float) -> float:
        """The potential [m]; inf where there is no way or it is not known."""
    def descent(self, x_m: float, y_m: float) -> tuple[float, float]:
        """The unit vector down the potential, (0, 0) where there is none."""
    def way(self, x_m: float, y_m: float, length_m: float, reach_m: float) -> npt.NDArray[np.float64]:
        """Down the potential for at most length_m: float64[k, 2]. From a place without a value it begins at the
        nearest one within reach_m that has one; there may be none: k is 0 then."""

class Guard:
    """Says which commands a base can still be stopped after without touching anything.

    Motions are (x, y, theta, v, w) in the map [m, rad, m/s, rad/s].
    """

    def __init__(self, footprint: Footprint, acceleration_mps2: float, yaw_acceleration_radps2: float) -> None: ...
    def look(self, map: ObstacleMap, x_m: float, y_m: float, reach_m: float, moving: npt.ArrayLike) -> None:
        """What there is now: the map's points within reach_m, and moving ones [k, 4] as (x, y, vx, vy)."""
    def gap(self, pose: npt.ArrayLike) -> float:
        """From the hull at (x, y, theta) to the nearest point [m], inf where there is none within reach."""
    def free(
        self,
        map: ObstacleMap,
        motion: npt.ArrayLike,
        v_mps: float,
        w_radps: float,
        hold_s: float,
        margin_m: float,
        linger_s: float = ...,
    ) -> bool:
        """Whether a base that moves so can follow the command for hold_s, then brake, and come no nearer than margin_m
        to anything meanwhile, or, where it is nearer already, no nearer still. What moves must leave it alone for
        linger_s after it stands, too."""
    @property
    def stirs(self) -> bool:
        """Whether anything moves."""
    def fits(self, pose: npt.ArrayLike, margin_m: float) -> bool:
        """Whether the hull fits there with so much margin."""

class Manoeuvre:
    """Finds a way out where the base does not simply fit through, with the hull as it is (hybrid A*): arcs forward,
    turns on the spot, and arcs back over ground that was seen. Source: Dolgov et al. 2010."""

    def __init__(self, footprint: Footprint) -> None: ...
    def begin(
        self,
        map: ObstacleMap,
        function: NavigationFunction,
        start: npt.ArrayLike,
        margin_m: float,
        others: npt.ArrayLike,
        value_m: float | None = ...,
        pose: npt.ArrayLike | None = ...,
        position_tolerance_m: float = ...,
        heading_tolerance: float = ...,
    ) -> None:
        """From a pose (x, y, theta), margin_m kept to the map's points and to others [k, 2], to where the function is
        at most value_m and the base looks down it, or to a pose within its tolerances: one of the two is given."""
    def advance(self, map: ObstacleMap, function: NavigationFunction, poses: int) -> bool:
        """Looks at so many more poses; True when the search is over."""
    @property
    def running(self) -> bool:
        """Whether one was begun and is not over."""
    @property
    def legs(self) -> list[tuple[float, float, tuple[float, float, float]]]:
        """What was found, empty where nothing was: way [m] (below 0 back, 0 for a turn on the spot), turn [rad] and
        the pose that the leg ends at."""

def followed(
    motion: npt.ArrayLike,
    v_mps: float,
    w_radps: float,
    acceleration_mps2: float,
    yaw_acceleration_radps2: float,
    duration_s: float,
) -> tuple[float, float, float, float, float]:
    """Where a base gets to, and how fast it is, that follows a command for some time from the motion that it has."""
