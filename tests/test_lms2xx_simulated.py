# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The LMS2xx's driver on the simulated scanner, in whatever state it is, and on whatever its line makes of it."""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
import pytest

from edgefusion.config import LaserConfig
from edgefusion.drivers.link import LinkLostError, LinkSilentError
from edgefusion.drivers.lms2xx import GIVEN_UP_S
from edgefusion.drivers.lms2xx_deskew import deskewed
from edgefusion.drivers.lms2xx_line import LaserError
from edgefusion.drivers.lms2xx_telegram import MAX_TELEGRAM_BYTES
from edgefusion.sim.lms_scanner import USUAL_BAUD
from edgefusion.types import HealthState, Scan
from lms_scenes import EXACT, MakeScene, Scene, scene

__all__ = ["scene"]
SPEEDS = [38400, 500000]
FAST = LaserConfig(baudrate=500000)


def is_good(made: Scene) -> bool:
    """Whether the driver gives the walls as they are."""
    scan = made.read(1.0)[-1]
    error_m = np.abs(scan.ranges_m - made.truth(scan.stamp_ns).ranges_m)
    return made.driver.health.state is HealthState.OK and bool(error_m.max() < 0.02)


@pytest.mark.parametrize("wanted", SPEEDS)
@pytest.mark.parametrize("left_at", [None, 9600, 19200, 38400, 500000])
def test_it_gets_scans_of_a_scanner_left_at_any_speed(scene: MakeScene, left_at: int | None, wanted: int) -> None:
    made = scene(LaserConfig(baudrate=wanted), left_at=left_at).started()
    assert made.scanner.line.baudrate == made.link.baudrate == wanted
    assert made.driver.model.startswith("LMS200;30106")
    assert is_good(made)


@pytest.mark.parametrize("wanted", SPEEDS)
@pytest.mark.parametrize("beams", [101, 181, 201, 361, 401])
def test_it_gets_as_many_beams_as_are_wanted_at_the_pace_of_mirror_or_line(scene: MakeScene, beams, wanted) -> None:
    made = scene(LaserConfig(baudrate=wanted, beams=beams)).started()
    scans = made.read(4.0)
    assert {len(scan.ranges_m) for scan in scans} == {beams}
    mirror_hz = {101: 75, 181: 75, 201: 37.5, 361: 37.5, 401: 18.75}[beams]
    assert len(scans) / 4 == pytest.approx(min(mirror_hz, wanted / 10 / (2 * beams + 10)), rel=0.08)
    ages_s = [(made.clock() - scan.stamp_ns) / 1e9 for scan in scans[-1:]]
    assert max(ages_s) < (made.driver.scan_age_limit_s or 0.0)


def test_partial_scans_come_with_every_turn_of_the_mirror(scene: MakeScene) -> None:
    made = scene(LaserConfig(baudrate=500000, partial_scans=True)).started()
    scans = made.read(1.0)
    assert len(scans) == pytest.approx(75, abs=2)
    firsts = {round(math.degrees(scan.angle_min), 1) for scan in scans}
    assert firsts == {-90.0, -89.5} and {len(scan.ranges_m) for scan in scans} == {181, 180}


def test_a_scanner_that_is_off_is_not_found_and_one_that_comes_on_is(scene: MakeScene) -> None:
    made = scene(power_up_s=35.0)
    attempts = 0
    while True:
        try:
            made.driver.start()
            break
        except LaserError:
            attempts += 1
            assert made.driver.health.state is HealthState.FAILED
    assert attempts > 2 and 40 <= made.clock() / 1e9 <= 50
    assert is_good(made)


@pytest.mark.parametrize("baudrate", SPEEDS)
def test_a_dip_of_its_power_is_noticed_and_it_is_set_up_anew(scene: MakeScene, baudrate: int) -> None:
    made = scene(LaserConfig(baudrate=baudrate)).started()
    made.read(1.0)
    made.scanner.power_cycle(made.clock(), 2.0)
    since_ns = made.clock()
    with pytest.raises(LinkSilentError):
        made.read(5.0)
    assert made.elapsed_s(since_ns) < 0.75
    made.clock.advance(2_000_000_000)
    made.driver.start()
    assert is_good(made)


@pytest.mark.parametrize("baudrate", SPEEDS)
def test_after_a_pulled_plug_scans_are_back_within_a_second(scene: MakeScene, baudrate: int) -> None:
    made = scene(LaserConfig(baudrate=baudrate)).started()
    made.read(1.03)
    made.line.plugged = False
    since_ns = made.clock()
    with pytest.raises(LinkLostError):
        made.read(1.0)
    assert made.elapsed_s(since_ns) <= 0.1
    made.clock.advance(1_234_567_890)
    made.line.plugged = True
    since_ns = made.clock()
    made.driver.start()
    while not made.driver.read():
        pass
    assert made.elapsed_s(since_ns) <= 1.0


@pytest.mark.parametrize(("baudrate", "limit_s"), [(38400, 0.53), (500000, 0.2)])
def test_a_line_that_falls_silent_is_lost_within_its_limit(scene: MakeScene, baudrate: int, limit_s: float) -> None:
    made = scene(LaserConfig(baudrate=baudrate)).started()
    made.read(1.0)
    made.inject("laser=off")
    since_ns = made.clock()
    with pytest.raises(LinkSilentError, match="nothing came for"):
        made.read(2.0)
    assert made.elapsed_s(since_ns) <= limit_s
    assert made.driver.health.state is HealthState.FAILED


@pytest.mark.parametrize(("baudrate", "limit_s"), [(38400, 0.53), (500000, 0.2)])
def test_a_line_of_noise_is_no_better_than_a_silent_one(scene: MakeScene, baudrate: int, limit_s: float) -> None:
    made = scene(LaserConfig(baudrate=baudrate)).started()
    made.read(1.0)
    made.inject("laser=garbage:0.05")
    since_ns = made.clock()
    while made.driver.health.state is not HealthState.FAILED:
        made.driver.read()
    assert made.elapsed_s(since_ns) <= limit_s
    assert "no scan for 0." in made.driver.health.reason
    made.mend()
    assert len(made.read(8.0)) > 10 and is_good(made)


def test_a_line_that_only_makes_noise_is_given_up(scene: MakeScene) -> None:
    made = scene(FAST).started()
    made.inject("laser=garbage:0.5")
    since_ns = made.clock()
    with pytest.raises(LaserError, match=r"no scan for 5\.0"):
        made.read(10.0)
    assert made.elapsed_s(since_ns) == pytest.approx(GIVEN_UP_S, abs=0.1)


@pytest.mark.parametrize(("noise", "least", "most"), [(0.0001, 240, 298), (0.001, 0, 10), (0.01, 0, 0)])
def test_what_comes_over_a_noisy_line_is_the_truth_or_nothing(scene: MakeScene, noise, least, most) -> None:
    made = scene(FAST).started()
    made.inject(f"laser=garbage:{noise}")
    scans: list[Scan] = []
    with suppress(LaserError):  # it may give up
        scans += made.read(4.0)
        scans += made.read(4.0)
    assert least <= len(scans) <= most
    assert all(np.abs(scan.ranges_m - made.truth(scan.stamp_ns).ranges_m).max() < 0.02 for scan in scans)


def test_a_scanner_that_repeats_itself_is_believed_only_for_a_moment(scene: MakeScene) -> None:
    made = scene(FAST).started()
    assert len(made.read(1.0, moving=True)) > 30
    made.inject("laser=stuck")
    assert len(made.read(1.0, moving=True)) <= 5
    assert "it repeats itself" in made.driver.health.reason
    made.mend()
    made.read(0.1)
    made.inject("laser=stuck")
    assert 30 <= len(made.read(3.0, moving=False)) <= 39
    assert made.driver.health.state is HealthState.FAILED


def test_a_covered_window_is_a_failure_from_the_second_scan_on(scene: MakeScene) -> None:
    made = scene(FAST).started()
    made.read(1.0)
    made.scanner.covered = True
    assert len(made.read(1.0)) <= 2
    assert made.driver.health.reason == "covered or dazzled: 361 of 361 beams see nothing"
    made.scanner.covered = False
    made.read(0.1)
    assert is_good(made)


def test_closing_leaves_it_quiet_at_the_speed_of_power_on(scene: MakeScene) -> None:
    made = scene(FAST).started()
    made.read(0.5)
    made.driver.close()
    made.clock.advance(100_000_000)
    made.scanner.transmit(None, made.clock())
    assert made.scanner.line.baudrate == USUAL_BAUD and not made.scanner.streaming


@pytest.mark.parametrize(("baudrate", "off_ms"), [(500000, 13), (38400, 27)])
def test_scans_that_were_read_late_are_stamped_as_if_they_were_not(scene: MakeScene, baudrate, off_ms: int) -> None:
    turning = math.radians(100)
    made = scene(LaserConfig(baudrate=baudrate), turn_radps=turning, real=EXACT, step_ns=100_000).started()
    made.read(1.0)
    late: list[Scan] = []
    for held_up_ms in range(60, 111, 5):
        made.clock.advance(held_up_ms * 1_000_000)
        late += made.read(0.2)
    worst = max(rms_m(deskewed(scan, made.history(scan), np.eye(4)), made.truth(scan.stamp_ns)) for scan in late)
    assert worst < 0.004 * off_ms  # what so many milliseconds of the turn make of this room


@pytest.mark.parametrize("halted_s", [0.3, 1.0, GIVEN_UP_S + 1])
def test_a_scanner_is_neither_lost_nor_missed_by_who_was_halted(scene: MakeScene, halted_s: float) -> None:
    made = scene(FAST).started()
    made.read(1.0)
    for ms in range(0, 28, 4):  # wherever within a scan it was halted
        made.read(0.1 + ms / 1000)
        for _ in range(round(halted_s * 100)):
            made.clock.advance(10_000_000)
            assert made.link.waiting_bytes >= 0
        scans = []
        while made.link.waiting_bytes > MAX_TELEGRAM_BYTES:
            scans += made.driver.read()
            assert made.driver.health.state is HealthState.OK
        assert len(scans) >= 37 * halted_s - 3


def rms_m(scan: Scan, truth: Scan) -> float:
    inner = slice(8, -8)  # beams at the edge have turned out of what was looked at
    return float(np.sqrt(np.nanmean((scan.ranges_m[inner] - truth.ranges_m[inner]) ** 2)))


def errors_m(made: Scene) -> tuple[float, float]:
    """Root mean square of the ranges' errors, as they came and deskewed."""
    scans = made.read(3.0)
    pairs = [(scan, made.truth(scan.stamp_ns)) for scan in scans]
    came = [rms_m(scan, truth) for scan, truth in pairs]
    straight = [rms_m(deskewed(scan, made.history(scan), np.eye(4)), truth) for scan, truth in pairs]
    return float(np.mean(came)), float(np.mean(straight))


@pytest.mark.parametrize("degrees_per_s", [-100, 100])
def test_a_turn_of_100_degrees_a_second_is_undone(scene: MakeScene, degrees_per_s: int) -> None:
    made = scene(FAST, turn_radps=math.radians(degrees_per_s), real=EXACT, step_ns=50_000).started()
    came, straight = errors_m(made)
    assert straight < 0.002 < 0.03 < came


def test_over_a_line_slower_than_the_mirror_no_more_than_the_wait_for_it_remains(scene: MakeScene) -> None:
    made = scene(turn_radps=math.radians(100), real=EXACT, step_ns=50_000).started()
    came, straight = errors_m(made)
    # Of 0.04 m that half a period, 13 ms, makes of a turn of 100 degrees a second.
    assert straight < 0.03 < 0.04 < came
