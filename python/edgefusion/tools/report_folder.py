# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The folder that `edgefusion demo` fills: index.html, report.json, detections.jsonl, pictures, plots, inspections."""

from __future__ import annotations

import re
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Sequence

from edgefusion.navigation.inspection_result import InspectionResult
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.tools.drive_log import DriveLog
from edgefusion.tools.drive_tally import FirstSighting
from edgefusion.tools.inspection_files import save_inspection
from edgefusion.tools.look_pictures import LookPictures
from edgefusion.tools.plan_plot import plan_plot, size_in
from edgefusion.tools.pose_plots import pose_plot, stop_plot
from edgefusion.tools.report import html
from edgefusion.tools.report_plots import Plot, error_plot, svgs
from edgefusion.tools.results import ResultsFolder
from edgefusion.tools.vision import Look
from edgefusion.types import UNKNOWN

PAGE, REPORT, PLOTS, INSPECTIONS = "index.html", "report.json", "plots", "inspections"
POSE_IN, STOP_IN, ERRORS_IN = (7.0, 5.2), (7.0, 4.6), (7.0, 3.0)


class Pictured(NamedTuple):
    """A first sighting and the names of its pictures, empty where there are none."""

    first: FirstSighting
    image: str
    scan: str


class Kept(NamedTuple):
    """An inspection and the names of its files; picture: empty where there is none."""

    result: InspectionResult
    picture: str
    json: str


class ReportFolder:
    """Takes the looks of a drive as they come, and the report at its end.

    Raises RefusedError where results lie already, and for what cannot be written.
    """

    def __init__(self, path: Path, overwrite: bool, pictures: LookPictures) -> None:
        self.path, self._pictures = path, pictures
        self._results = ResultsFolder(path, overwrite, also=(PAGE, REPORT, PLOTS, INSPECTIONS))
        self.pictured: list[Pictured] = []

    def __enter__(self) -> ReportFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._results.__exit__(kind, error, trace)

    def add(self, look: Look, confirmed: Sequence[FirstSighting]) -> None:
        """The detections of a look, and pictures of what it confirmed."""
        self._results.write_detections(look.number, look.detections)
        for first in confirmed:
            if not _worth_a_picture(first):
                self.pictured.append(Pictured(first, "", ""))
                continue
            name = f"{len(self.pictured):02d}-{_slug(first.sighting.label)}"
            image, scan = f"annotated/{name}.jpg", f"scans/{name}.png"
            self._results.write_image(image, self._pictures.camera(look.shot, [first.detection]))
            self._results.write_image(scan, self._pictures.scan(look.shot, [first.detection]))
            self.pictured.append(Pictured(first, image, scan))

    def keep(self, result: InspectionResult) -> Kept:
        """The picture and the JSON of an inspection."""
        path = save_inspection(self.path / INSPECTIONS, result)
        picture = "" if result.picture is None else f"{INSPECTIONS}/{path.with_suffix('.jpg').name}"
        return Kept(result, picture, f"{INSPECTIONS}/{path.name}")

    def write(self, report: dict[str, Any], world: BuiltWorld, log: DriveLog, errors_m: Any) -> None:
        """The plots, report.json and the page."""
        goal = world.world.goal
        self._write_plot("plan", plan_plot(world, log.trail, report), size_in(world, log.trail))
        self._write_plot("pose", pose_plot(log.trail, goal, log.inspections), POSE_IN)
        for result in log.inspections:
            self._write_plot(result.id, stop_plot(log.trail, result), STOP_IN)
        self._write_plot("errors", error_plot(errors_m), ERRORS_IN)
        self._results.write_summary(report, REPORT)
        self._results.write_file(PAGE, html(report).encode())

    def _write_plot(self, name: str, plot: Plot, size_in: tuple[float, float]) -> None:
        for ending, svg in svgs(plot, size_in):
            self._results.write_file(f"{PLOTS}/{name}{ending}", svg)


def _worth_a_picture(first: FirstSighting) -> bool:
    """What got a name, and what has none: neither walls without a name, nor what only had none at first."""
    nameless = first.thing is not None and first.thing.kind.label == UNKNOWN
    return nameless or first.sighting.label != UNKNOWN


def _slug(label: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", label.lower()).strip("-") or "thing"
