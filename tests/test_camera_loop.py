# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The turns of capturing, by an injected clock: what ends or hangs is opened again, later each time."""

from __future__ import annotations

import pytest

from camera_scenes import ScriptedSource, flat, scene
from edgefusion.clock import SimClock
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera_loop import CaptureLoop
from edgefusion.drivers.camera_pipe import PipeEndedError
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.drivers.camera_source import Picture
from edgefusion.types import HealthState

MS = 1_000_000
SECOND = 1000 * MS


class Bench:
    """A loop whose sources come from a list; where that is at its end, nothing can be opened."""

    def __init__(self, *sources: ScriptedSource, **settings) -> None:
        self.clock, self.opened_at_ns = SimClock(0), []
        self._sources = list(sources)
        self.loop = CaptureLoop(self._open, CameraConfig(**settings), self.clock)

    def _open(self) -> ScriptedSource:
        self.opened_at_ns.append(self.clock())
        if not self._sources:
            raise PipeEndedError("/dev/video0: not there")
        return self._sources.pop(0)

    def run(self, duration_ns: int, turn_ns: int = 10 * MS) -> list[str]:
        """Steps through the time; returns the code of the health after every turn."""
        codes = []
        for _ in range(duration_ns // turn_ns):
            self.loop.step(0.01)
            codes.append(self.loop.health().reason.partition(":")[0])
            self.clock.advance(turn_ns)
        return codes


def stream(start_ns: int, count: int, image=scene) -> list[Picture]:
    return [Picture(start_ns + number * 10 * MS, image(number)) for number in range(count)]


def test_pictures_are_stamped_before_their_arrival_by_the_exposure() -> None:
    bench = Bench(ScriptedSource(stream(10 * MS, 5)), exposure_offset_s=0.004)
    bench.run(60 * MS)
    assert [frame.stamp_ns for frame in bench.loop.after(0)] == [(6 + 10 * number) * MS for number in range(5)]
    assert bench.loop.latest(0.1).stamp_ns == 46 * MS


def test_a_stale_picture_is_not_given() -> None:
    bench = Bench(ScriptedSource(stream(10 * MS, 1)))
    bench.run(20 * MS)
    bench.clock.advance(200 * MS)
    with pytest.raises(NoFrameError, match="age of the newest picture"):
        bench.loop.latest(0.2)
    bench.clock.advance(400 * MS)
    with pytest.raises(NoFrameError, match="CAMERA_LOST"):
        bench.loop.latest(10.0)


def test_the_end_of_a_source_is_told_at_once_and_it_is_opened_again() -> None:
    first = ScriptedSource([*stream(10 * MS, 3), "/dev/video0: no more pictures"])
    bench = Bench(first, ScriptedSource(stream(150 * MS, 3)))
    bench.run(50 * MS)
    assert bench.loop.health().reason == "CAMERA_LOST: /dev/video0: no more pictures"
    assert first.closed == 1
    bench.run(130 * MS)
    assert bench.loop.health().state is HealthState.OK
    assert bench.opened_at_ns == [0, 140 * MS]


def test_a_camera_that_is_not_there_is_looked_for_ever_less_often_but_every_second() -> None:
    bench = Bench()
    codes = bench.run(6 * SECOND)
    assert [at / SECOND for at in bench.opened_at_ns] == pytest.approx([0, 0.1, 0.3, 0.7, 1.5, 2.5, 3.5, 4.5, 5.5])
    assert set(codes) == {"CAMERA_LOST"}


def test_a_good_picture_makes_the_pauses_short_again() -> None:
    broken = [ScriptedSource(["broken"]) for _ in range(4)]
    good = ScriptedSource([Picture(1600 * MS, scene(0)), "broken"])
    bench = Bench(*broken, good, ScriptedSource([]))
    bench.run(3 * SECOND)
    assert bench.opened_at_ns[5] - bench.opened_at_ns[4] < 150 * MS


def test_a_read_that_hangs_is_abandoned_after_its_time() -> None:
    hanging = ScriptedSource(stream(10 * MS, 1))
    bench = Bench(hanging, ScriptedSource(stream(1200 * MS, 1)))
    codes = bench.run(1200 * MS)
    assert hanging.closed == 1
    assert codes.index("CAMERA_LOST") * 10 * MS <= 500 * MS
    assert 1000 * MS < bench.opened_at_ns[1] <= 1200 * MS


def test_a_process_that_was_halted_does_not_take_its_camera_for_hanging() -> None:
    source = ScriptedSource([*stream(10 * MS, 1), None, Picture(3030 * MS, scene(1))])
    bench = Bench(source)
    bench.run(20 * MS)
    bench.clock.advance(3 * SECOND)
    assert bench.run(30 * MS)[-1] == ""
    assert source.closed == 0 and len(bench.opened_at_ns) == 1


def test_a_camera_that_never_opens_is_abandoned_after_its_time() -> None:
    hanging = ScriptedSource([])
    bench = Bench(hanging)
    codes = bench.run(5 * SECOND)
    assert (set(codes), hanging.closed) == ({"CAMERA_STARTING"}, 0)
    bench.run(1 * SECOND)
    assert (bench.loop.health().reason[:11], hanging.closed) == ("CAMERA_LOST", 1)


def test_nothing_of_a_frozen_camera_is_given_and_it_is_opened_again() -> None:
    frozen = ScriptedSource(stream(10 * MS, 200, lambda number: scene(0)))
    # What is opened again begins with the old picture.
    bench = Bench(frozen, ScriptedSource(stream(1000 * MS, 3)))
    codes = bench.run(900 * MS)
    assert codes.index("CAMERA_FROZEN") * 10 * MS <= 1000 * MS
    assert (frozen.closed, bench.loop.after(0)) == (1, [])
    with pytest.raises(NoFrameError, match="CAMERA_FROZEN"):
        bench.loop.latest(10.0)
    bench.run(130 * MS)
    assert bench.loop.health().state is HealthState.OK
    assert len(bench.loop.after(0)) == 2


def test_nothing_of_a_blind_camera_is_given_and_it_stays_open() -> None:
    dark = stream(10 * MS, 60, lambda number: flat(number % 2))
    source = ScriptedSource([*dark, *stream(610 * MS, 1)])
    bench = Bench(source)
    codes = bench.run(610 * MS)
    assert codes.index("CAMERA_BLIND") * 10 * MS <= 1000 * MS
    assert bench.loop.after(0) == []
    with pytest.raises(NoFrameError, match="CAMERA_BLIND: black"):
        bench.loop.latest(10.0)
    bench.run(10 * MS)
    assert len(bench.loop.after(0)) == 1
    assert source.closed == 0


def test_closing_lets_go_of_the_device_once() -> None:
    source = ScriptedSource([])
    bench = Bench(source)
    bench.run(20 * MS)
    bench.loop.close()
    bench.loop.close()
    assert source.closed == 1
