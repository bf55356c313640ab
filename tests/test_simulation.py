# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One world in simulated time: what it delivers depends on seed, stamps and commands, and on nothing else."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Iterator

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.sim.built_world import BuiltWorld, build
from edgefusion.sim.exposure import CameraSpec
from edgefusion.sim.floor_plan import BUILDING, NOTHING_MET
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.laser import LaserSpec
from edgefusion.sim.pace import Pace
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.robot import BaseSpec
from edgefusion.sim.simulation import SensorSpec, Simulation
from edgefusion.sim.world import Thing, Wall, World
from edgefusion.types import Pose2D, Twist2D
from sim_scenes import skip_without_renderer

SECOND_NS = 1_000_000_000
RIG = Rig()
AHEAD = Twist2D(0.3, 0.2)


@pytest.fixture(scope="module")
def world() -> BuiltWorld:
    """A wall on one side, free on the other, an object ahead."""
    wall = Wall((-1.0, 2.0), (6.0, 2.0), 2.4, 0.1, "plaster")
    thing = Thing("scope", CATALOGUE["oscilloscope"], Pose2D(3.0, 0.3, math.pi), 1)
    return build(
        World("small", 3, "linoleum", None, (wall,), (thing,), Pose2D(0.5, 0.2, 0.1), Pose2D(2, 0)),
        RIG.laser_height_m,
    )


@pytest.fixture(scope="module")
def renderer() -> Iterator[Renderer]:
    skip_without_renderer()
    with Renderer(RIG) as open_renderer:
        yield open_renderer


def driven(world: BuiltWorld, renderer: Renderer | None = None, seed: int = 0, base: BaseSpec | None = None):
    simulation = Simulation(world, RIG, renderer, seed, base)
    simulation.command(AHEAD)
    simulation.step_to(SECOND_NS)
    return simulation


def newest(simulation: Simulation) -> tuple[bytes, bytes]:
    scan, frame = simulation.scan(simulation.scan_stamps(-1)[-1]), simulation.frame(simulation.frame_stamps(-1)[-1])
    return scan.ranges_m.tobytes(), frame.image.tobytes()


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(world, renderer) -> None:
    first = newest(driven(world, renderer))
    assert newest(driven(world, renderer)) == first
    scan, image = newest(driven(world, renderer, seed=1))
    assert scan != first[0] and image != first[1]


def test_a_scan_and_a_frame_do_not_depend_on_which_others_were_asked_for(world, renderer) -> None:
    lazy, keen = Simulation(world, RIG, renderer, 5), Simulation(world, RIG, renderer, 5)
    for simulation in (lazy, keen):
        simulation.command(AHEAD)
    for stamp_ns in range(0, SECOND_NS + 1, 50_000_000):
        keen.step_to(stamp_ns)
        for scan_ns in keen.scan_stamps(stamp_ns - 100_000_000):
            keen.scan(scan_ns)
    lazy.step_to(SECOND_NS)
    assert newest(lazy) == newest(keen)
    assert (lazy.pose, lazy.odometry) == (keen.pose, keen.odometry)


def test_scans_and_frames_come_at_the_pace_of_the_real_sensors(world) -> None:
    simulation = driven(world)
    scans, frames = simulation.scan_stamps(-1), simulation.frame_stamps(-1)
    assert set(np.diff(scans)) == {26_666_666}  # two mirror turns: 37.5 a second
    assert set(np.diff(frames)) == {33_333_333}
    assert [simulation.scan(stamp_ns).stamp_ns for stamp_ns in scans] == scans
    assert scans[-1] + 20_000_000 < simulation.stamp_ns < scans[-1] + 60_000_000  # measured, sent, no older than that
    assert simulation.scan_stamps(scans[-3]) == scans[-2:]


def test_nothing_has_come_before_it_could_be_measured(world) -> None:
    simulation = Simulation(world, RIG, None, 0)
    assert simulation.scan_stamps(-1) == simulation.frame_stamps(-1) == []


def test_without_slip_the_odometry_is_the_truth_and_with_it_it_is_not(world) -> None:
    start = world.world.start
    exact, slipping = driven(world), driven(world, base=BaseSpec(slip_m=0.01))
    for simulation, apart in ((exact, False), (slipping, True)):
        believed = start.compose(simulation.odometry)
        assert (math.hypot(believed.x_m - simulation.pose.x_m, believed.y_m - simulation.pose.y_m) > 1e-4) is apart
    assert exact.pose_at(SECOND_NS) == exact.pose
    assert exact.odometry_at(SECOND_NS) == exact.odometry
    assert exact.odometry_at(SECOND_NS // 2).x_m < exact.odometry.x_m


def test_laser_and_base_run_without_a_renderer(world) -> None:
    simulation = driven(world)
    assert np.isfinite(simulation.scan(simulation.scan_stamps(-1)[-1]).ranges_m).sum() > 100
    with pytest.raises(RefusedError, match="camera: this simulation has no renderer"):
        simulation.frame(simulation.frame_stamps(-1)[-1])


def test_every_beam_has_an_owner_and_the_nearest_of_an_objects_is_its_true_range(world, renderer) -> None:
    simulation = driven(world, renderer)
    scan_ns, frame_ns = simulation.scan_stamps(-1)[-1], simulation.frame_stamps(-1)[-1]
    scan, owners = simulation.scan(scan_ns), simulation.owners(scan_ns)
    assert set(owners.tolist()) == {0, BUILDING, NOTHING_MET}
    assert not np.isfinite(scan.ranges_m[owners == NOTHING_MET]).any()
    (truth,) = simulation.truth(scan_ns, frame_ns)
    assert truth.name == "scope"
    assert float(np.nanmin(scan.ranges_m[owners == 0])) == pytest.approx(truth.range_m, abs=0.06)


def test_gain_and_tint_are_those_of_the_drive(world, renderer) -> None:
    """A robot that stands still sees the same world under the same light: what is left is gain, tint and noise."""

    def levels(seed: int, camera: CameraSpec) -> np.ndarray:
        simulation = Simulation(world, RIG, renderer, seed, sensors=SensorSpec(camera=camera))
        simulation.step_to(SECOND_NS // 2)
        frames = [simulation.frame(stamp_ns).image for stamp_ns in simulation.frame_stamps(-1)[:3]]
        return np.array([frame[300:].mean(axis=(0, 1)) for frame in frames])

    plain = CameraSpec(gain_sigma=0.0, tint_sigma=0.0)
    factors = np.array([levels(seed, CameraSpec()) / levels(seed, plain) for seed in range(3)])
    assert np.ptp(factors, axis=1).max() < 0.003
    assert np.ptp(factors[:, 0].mean(axis=1)) > 0.02
    assert np.ptp(factors[:, 0], axis=1).max() > 0.005


def test_a_turn_blurs_the_picture_along_its_rows(world, renderer) -> None:
    def sharpness(twist: Twist2D) -> float:
        simulation = Simulation(world, RIG, renderer, 0)
        simulation.command(twist)
        simulation.step_to(SECOND_NS)
        image = simulation.frame(simulation.frame_stamps(-1)[-1]).image[100:300].astype(float)
        return float(np.abs(np.diff(image, axis=1)).mean())

    assert sharpness(Twist2D(0, 1.5)) < 0.9 * sharpness(Twist2D())


@pytest.mark.parametrize("stamp_ns", [1, 10**12 + 1, -5])
def test_a_stamp_that_no_scan_has_is_refused(world, stamp_ns: int) -> None:
    with pytest.raises(RefusedError, match="stamp_ns: expected"):
        driven(world).scan(stamp_ns)


@pytest.mark.parametrize(("name", "value"), [("frame_period_ns", 0), ("line_ns", -1), ("transfer_ns", -1)])
def test_sensors_that_cannot_be_are_refused(name: str, value: int) -> None:
    with pytest.raises(RefusedError, match=f"^{name}: expected at least [01], got {value}$"):
        replace(SensorSpec(), **{name: value})


def test_a_laser_that_turns_in_no_time_does_not_scan_by_itself() -> None:
    with pytest.raises(RefusedError, match=r"^turn_ns: expected at least 1 .*, got 0$"):
        SensorSpec(laser=LaserSpec(turn_ns=0))


def test_a_pace_names_its_stamps_when_they_are_there() -> None:
    pace = Pace(first_ns=5, period_ns=10, delay_ns=3)
    assert [pace.since(-1, now) for now in (7, 8, 17, 18)] == [[], [5], [5], [5, 15]]
    assert pace.since(-1, 27) == [5, 15]
    assert pace.since(5, 28) == [15, 25]
    assert [pace.index(stamp) for stamp in (5, 25)] == [0, 2]
