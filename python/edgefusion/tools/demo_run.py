# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The demo: a drive through a world, watched by the detector, by the report and, if asked for, by somebody."""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

from tqdm import tqdm

from edgefusion.clock import Clock, system_clock
from edgefusion.config import Config
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.sim.built_world import build
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.robot import BaseSpec
from edgefusion.sim.simulation import Simulation
from edgefusion.sim.world import World
from edgefusion.tools.drive import Drive, Look, Pacing
from edgefusion.tools.drive_report import report_of
from edgefusion.tools.drive_tally import DriveTally
from edgefusion.tools.geometry import calibration_of
from edgefusion.tools.live_view import LiveView
from edgefusion.tools.look_pictures import LookPictures
from edgefusion.tools.report_folder import ReportFolder

BASE = BaseSpec(slip_m=0.002, left_drift_percent=0.1)
"""A base whose odometry is off by some centimetres after ten metres, as a good one's is."""

_NS_PER_S = 1e9
_BAR = "{l_bar}{bar}| {n:.1f} of {total:.1f} m [{elapsed}<{remaining}]"


@dataclass(frozen=True)
class DemoOptions:
    """port: of the live view, 0 for a free one, None for no view. command: what was typed, for the report."""

    world: World
    out: Path
    overwrite: bool
    model: Path
    seed: int
    port: int | None
    command: str


def run_demo(options: DemoOptions) -> dict[str, Any]:
    """Drives, writes the report's folder, returns what is in report.json. Raises RefusedError."""
    rig, config = Rig(), Config()
    calibration = calibration_of(rig)
    detector = Detector(open_classifier(options.model), calibration, config.perception)
    pictures = LookPictures(calibration, config.perception)
    with ExitStack() as stack:
        folder = stack.enter_context(ReportFolder(options.out, options.overwrite, pictures))
        renderer = stack.enter_context(Renderer(rig))
        view = None if options.port is None else stack.enter_context(_open_view(options.port))
        began_ns = system_clock()
        world = build(options.world, rig.laser_height_m)
        simulation = Simulation(world, rig, renderer, options.seed, BASE)
        pacing = _as_fast_as_it_can if view is None else real_time(system_clock)
        drive, tally = Drive(simulation, detector, config.sync, pacing), DriveTally(world, calibration)
        for look in _with_progress(drive):
            folder.add(look, tally.add(look))
            if view is not None:
                view.show(pictures.everything(look.shot, look.detections))
        report = {
            **report_of(world, drive, tally, folder.pictured),
            "command": options.command,
            "model": str(options.model),
            "seed": options.seed,
            "live": view is not None,
            "took_s": (system_clock() - began_ns) / _NS_PER_S,
        }
        folder.write(report, world, drive.trail, tally.distance_errors_m())
    return report


def _open_view(port: int) -> LiveView:
    """Waits until somebody looks: the drive would be over before."""
    view = LiveView(port)
    print(f"edgefusion: open {view.url} in a browser: the drive begins then (Ctrl-C ends it)", file=sys.stderr)
    try:
        view.wait_for_someone()
    except BaseException:
        view.close()
        raise
    return view


def _with_progress(drive: Drive) -> Iterator[Look]:
    """The looks of a drive, with a bar that shows how far it has got."""
    with tqdm(total=drive.way_m, bar_format=_BAR, disable=None, file=sys.stderr) as bar:
        for look in drive:
            bar.update(drive.way_m - drive.way_left_m - bar.n)
            yield look
        bar.update(drive.way_m - bar.n)


def _as_fast_as_it_can(stamp_ns: int) -> None:
    """Nobody watches."""


def real_time(clock: Clock) -> Pacing:
    """Holds simulated time up until it is due."""
    began_ns = clock()

    def wait(stamp_ns: int) -> None:
        time.sleep(max(0, began_ns + stamp_ns - clock()) / _NS_PER_S)

    return wait
