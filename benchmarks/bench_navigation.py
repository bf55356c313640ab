# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A navigator's step against what is promised of it, and its potential anew against a Dijkstra search of SciPy's.

The steps are those of one drive of a Pioneer 3-DX through a room with things, 361 beams, 5 cm cells. The potential is
computed anew for what that drive has seen, from the goal until the start is passed; the peer searches the same cells
for the same cost, with a distance transform of OpenCV's, over eight neighbours.
"""

from __future__ import annotations

import time
from typing import Callable, Dict, List, Tuple

import numpy as np
import numpy.typing as npt
from benchmarks.grid_dijkstra import Cost, dijkstra
from benchmarks.maze_worlds import make
from benchmarks.mazes import BASE, spec_of
from benchmarks.nav_run import drive
from benchmarks.timing import Row, interleaved

from edgefusion._core import NavigationFunction, ObstacleMap
from edgefusion.config import NavigationConfig
from edgefusion.navigation.navigator import Navigator
from edgefusion.navigation.progress import Progress
from edgefusion.sim.plan_simulation import PlanSimulation
from edgefusion.types import Goal, Pose2D, Scan, Twist2D

Floats = npt.NDArray[np.float64]
Moment = Tuple[int, "Scan | None", Pose2D, Goal]
"""What a navigator's step is given."""

FAMILY, SEED, LIMIT_S = "slip", 0, 60.0
CONFIG = NavigationConfig()
MEDIAN_S, WORST_S = 5e-3, 20e-3
ALL_CELLS = 10**9
PRODUCT, DIJKSTRA = "product", "OpenCV's distances, SciPy's Dijkstra"

INSCRIBED_M = min(abs(coordinate) for corner in BASE.footprint_m for coordinate in corner)
COST = Cost(CONFIG.cell_m, INSCRIBED_M, INSCRIBED_M + CONFIG.comfort_m, CONFIG.comfort_weight)


class Recorder:
    """A navigator that keeps what it was given."""

    def __init__(self) -> None:
        self._navigator = Navigator(CONFIG, BASE)
        self.moments: List[Moment] = []

    def step(self, stamp_ns: int, scan: Scan | None, pose: Pose2D, goal: Goal) -> tuple[Twist2D, Progress]:
        self.moments.append((stamp_ns, scan, pose, goal))
        answer: tuple[Twist2D, Progress] = self._navigator.step(stamp_ns, scan, pose, goal)
        return answer


def recorded() -> List[Moment]:
    """The steps of a drive to its goal."""
    world, recorder = make(FAMILY, SEED), Recorder()
    sim = PlanSimulation(world.segments_at, world.start, spec_of(world), SEED)
    drive(sim, recorder, Goal("goal", world.goal.relative_to(world.start)), LIMIT_S, lambda _: True)
    return recorder.moments


def step_times_s(moments: List[Moment], rounds: int) -> Floats:
    """Of each step the median over so many drives with the same scans: float64[steps]."""
    taken = np.empty((rounds, len(moments)))
    for times in taken:
        navigator = Navigator(CONFIG, BASE)
        for i, (stamp_ns, scan, pose, goal) in enumerate(moments):
            start = time.perf_counter()
            navigator.step(stamp_ns, scan, pose, goal)
            times[i] = time.perf_counter() - start
    return np.asarray(np.median(taken, axis=0))


def map_of(moments: List[Moment], goal: Pose2D) -> ObstacleMap:
    """What the drive's scans show; the base drives slowly, so each is placed where it was seen last."""
    seen = ObstacleMap(CONFIG.cell_m)
    for _, scan, pose, _ in moments:
        seen.cover(pose.x_m, pose.y_m, goal.x_m, goal.y_m)
        if scan is not None:
            laser = pose.compose(Pose2D(*BASE.laser_pose))
            poses = np.tile((laser.x_m, laser.y_m, laser.theta), (len(scan.ranges_m), 1))
            beams = scan.ranges_m, scan.angle_min, scan.angle_increment, scan.range_min_m, scan.range_max_m
            seen.insert(poses, *beams, scan.stamp_ns)
    return seen


def anew(seen: ObstacleMap, goal: Pose2D, start: Pose2D) -> float:
    """edgefusion's potential at the start [m]."""
    function = NavigationFunction(COST.blocked_m, COST.comfort_m, COST.weight)
    function.begin(seen, goal.x_m, goal.y_m, CONFIG.cell_m, start.x_m, start.y_m)
    function.advance(seen, ALL_CELLS)
    return function.value(start.x_m, start.y_m)


def candidates(seen: ObstacleMap, goal: Pose2D, start: Pose2D) -> Dict[str, Callable[[], object]]:
    return {PRODUCT: lambda: anew(seen, goal, start), DIJKSTRA: lambda: dijkstra(COST, seen, goal, start)}


def rows(rounds: int = 11) -> list[Row]:
    """The rows of the common table."""
    moments = recorded()
    times_s = step_times_s(moments, rounds)
    steps = f"Navigator.step, 361 beams, 5 cm cells, {len(moments)} steps"
    table = [
        _limited(f"{steps}: median", float(np.median(times_s)), MEDIAN_S),
        _limited(f"{steps}: worst", float(times_s.max()), WORST_S),
    ]
    world = make(FAMILY, SEED)
    goal, start = world.goal.relative_to(world.start), Pose2D()
    seen = map_of(moments, goal)
    ours_m, theirs_m = anew(seen, goal, start), dijkstra(COST, seen, goal, start)
    assert 0.9 < ours_m / theirs_m < 1.05, (
        f"{ours_m} m and {theirs_m} m"
    )  # steps over eight neighbours go round corners
    taken = interleaved(candidates(seen, goal, start), rounds)
    columns, height = seen.window[2:]
    name = f"the potential anew, {columns} x {height} cells"
    ratio = taken[DIJKSTRA] / taken[PRODUCT]
    return [*table, Row(name, taken[PRODUCT], DIJKSTRA, taken[DIJKSTRA], ratio, None)]


def _limited(name: str, taken_s: float, limit_s: float) -> Row:
    return Row(name, taken_s, "at most, as promised", limit_s, limit_s / taken_s, 1.0)


if __name__ == "__main__":
    for row in rows():
        print(f"{row.name}: {1e3 * row.product_s:.2f} ms, {row.peer} {1e3 * row.peer_s:.2f} ms, {row.ratio:.1f} times")
