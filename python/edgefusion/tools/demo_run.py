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
from edgefusion.sim.built_world import build
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.world import World
from edgefusion.tools.demo_robot import demo_robot
from edgefusion.tools.drive import Drive, Pacing
from edgefusion.tools.drive_report import report_of
from edgefusion.tools.drive_tally import DriveTally
from edgefusion.tools.live_view import LiveView
from edgefusion.tools.report_folder import ReportFolder
from edgefusion.tools.vision import Look

_NS_PER_S = 1e9
_BAR = "{desc} {percentage:3.0f}%|{bar}| {n:.1f} of {total:.1f} m [{elapsed}]"


@dataclass(frozen=True)
class DemoOptions:
    """interest: labels and groups to inspect. port: of the live view, 0 for a free one, None for no view. command:
    what was typed, for the report."""

    world: World
    out: Path
    overwrite: bool
    model: Path
    seed: int
    interest: tuple[str, ...]
    port: int | None
    command: str


def run_demo(options: DemoOptions) -> dict[str, Any]:
    """Drives, writes the report's folder, returns what is in report.json. Raises RefusedError."""
    robot = demo_robot(options.model, options.interest)
    with ExitStack() as stack:
        folder = stack.enter_context(ReportFolder(options.out, options.overwrite, robot.pictures))
        renderer = stack.enter_context(Renderer(robot.rig))
        view = None if options.port is None else stack.enter_context(_open_view(options.port))
        began_ns = system_clock()
        world = build(options.world, robot.rig.laser_height_m)
        pacing = as_fast_as_it_can if view is None else real_time(system_clock)
        drive = robot.drive(world, renderer, options.seed, pacing)
        tally = DriveTally(world, robot.calibration)
        for look in _with_progress(drive):
            folder.add(look, tally.add(look))
            if view is not None:
                view.show(robot.pictures.everything(look.shot, look.detections))
        inspected = [folder.keep(result) for result in drive.log.inspections]
        report = {
            **report_of(world, drive, tally, folder.pictured, inspected),
            "command": options.command,
            "model": str(options.model),
            "seed": options.seed,
            "live": view is not None,
            "took_s": (system_clock() - began_ns) / _NS_PER_S,
        }
        folder.write(report, world, drive.log, tally.distance_errors_m())
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
    """The looks of a drive, with a bar that shows what the mission does and how far it has got: straight to the goal,
    and never back, though a way round something leads away from it for a while."""
    with tqdm(total=drive.way_m, bar_format=_BAR, disable=None, file=sys.stderr) as bar:
        for look in drive:
            bar.set_description_str(f"{drive.state.value:<10}", refresh=False)
            bar.update(max(0.0, drive.way_m - drive.way_left_m - bar.n))
            yield look
        bar.set_description_str(f"{drive.state.value:<10}")


def as_fast_as_it_can(stamp_ns: int) -> None:
    """Nobody watches."""


def real_time(clock: Clock) -> Pacing:
    """Holds simulated time up until it is due."""
    began_ns = clock()

    def wait(stamp_ns: int) -> None:
        time.sleep(max(0, began_ns + stamp_ns - clock()) / _NS_PER_S)

    return wait
