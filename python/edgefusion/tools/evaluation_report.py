# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The folder of `edgefusion evaluate`: figures.json, figures.md, plots, and pictures of what went wrong."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, Mapping, Sequence

import cv2
import msgspec

from edgefusion.errors import RefusedError
from edgefusion.tools.draw import WHITE, draw_tag
from edgefusion.tools.evaluation import Look, Outcome, Watcher
from edgefusion.tools.look_pictures import LookPictures
from edgefusion.tools.measure import Seen
from edgefusion.tools.writing import writing
from edgefusion.types import Detection

FAILURES = 24
"""Pictures of frames in which something that counts went wrong, at most."""

POOR_IOU = 0.5
FIGURES = "figures.json"
_HEAD = (
    "objects", "recall", "label", "IoU", "height error, median / p95", "width error, median / p95",
    "distance bias", "distance p95", "within 2 sigma",
)  # fmt: skip


class EvaluationFolder:
    """Where the results go; nothing is touched before the first of them.

    Raises RefusedError where some lie already and may not be replaced, and for what cannot be written.
    """

    def __init__(self, path: Path, overwrite: bool, pictures: LookPictures) -> None:
        self.path, self._pictures, self._kept, self._begun = path, pictures, 0, False
        if path.exists() and not path.is_dir():
            raise RefusedError(f"{path}: expected a folder, or nothing yet, got a file")
        if (path / FIGURES).exists() and not overwrite:
            raise RefusedError(f"{path / FIGURES}: exists already; --overwrite replaces it, --out takes another")

    def keep_failures(self, setting: str) -> Watcher:
        """Keeps pictures of one setting's failures as they come."""

        def watch(name: str, look: Look, detections: Sequence[Detection], seen: Sequence[Seen]) -> None:
            wrong = [each for each in seen if each.free and not _well(each)]
            if name != setting or not wrong or self._kept >= FAILURES:
                return
            self._kept += 1
            self._write(f"failures/{look.number:05d}.jpg", self._picture(look, detections, wrong))

        return watch

    def write(self, report: dict[str, Any], outcomes: Mapping[str, Outcome]) -> str:
        """Everything; returns the table as Markdown."""
        from edgefusion.tools.evaluation_plots import plot_all

        table = markdown(report)
        self._write("figures.md", f"{table}\n".encode())
        with writing(self.path):
            plot_all(self.path, outcomes)
        self._write(FIGURES, f"{self.json(report)}\n".encode())
        return table

    @staticmethod
    def json(report: dict[str, Any]) -> str:
        """The figures for a program."""
        return msgspec.json.format(msgspec.json.encode(report), indent=2).decode()

    def _write(self, name: str, content: bytes) -> None:
        with writing(self.path / name):
            if not self._begun:
                shutil.rmtree(self.path / "failures", ignore_errors=True)
                self._begun = True
            (self.path / name).parent.mkdir(parents=True, exist_ok=True)
            (self.path / name).write_bytes(content)

    def _picture(self, look: Look, detections: Sequence[Detection], wrong: Sequence[Seen]) -> bytes:
        picture = self._pictures.camera(look.shot, detections)
        for i, each in enumerate(wrong):
            line = f"{each.kind} at {each.range_m:.1f} m: " + (
                f"called {each.said}, IoU {each.iou:.2f}" if each.found else "not found"
            )
            draw_tag(picture, line, (0, 20 * (i + 1)), WHITE, 0.45)
        return cv2.imencode(".jpg", picture)[1].tobytes()


def _well(seen: Seen) -> bool:
    return seen.found and seen.named and seen.iou is not None and seen.iou >= POOR_IOU


def markdown(report: dict[str, Any]) -> str:
    """The tables of a report."""
    settings = report["settings"]
    lines = [_row(("", *_HEAD)), _row(["---"] * (len(_HEAD) + 1))]
    for group, title in (("free", "free-standing"), ("touching", "touching"), ("all", "everything in view")):
        lines += [_row((f"{title}, {name}", *cells(summary[group]))) for name, summary in settings.items()]
    lines += ["", _row(("", "detections", "are an object", "with a name", "with the right one")), _row(["---"] * 5)]
    for name, summary in settings.items():
        p = summary["precision"]
        shares = (p["detections"], _share(p["precision"]), p["named"], _share(p["named_right"]))
        lines.append(_row((name, *map(str, shares))))
    for title, key in (("by range", "by_range"), ("by kind", "by_kind")):
        for setting, summary in settings.items():
            lines += ["", _row((f"{setting}, free-standing, {title}", *_HEAD)), _row(["---"] * (len(_HEAD) + 1))]
            lines += [_row((name, *cells(each))) for name, each in summary[key].items()]
    return "\n".join(lines)


def cells(f: dict[str, Any]) -> list[str]:
    """One row's figures as people read them."""
    return [
        str(f["objects"]),
        _number(f["recall"], "{:.3f}"),
        _number(f["label_accuracy"], "{:.3f}"),
        _number(f["mean_iou"], "{:.3f}"),
        f"{_share(f['height_error_median'])} / {_share(f['height_error_p95'])}",
        f"{_number(f['width_error_px_median'], '{:.1f}')} / {_number(f['width_error_px_p95'], '{:.1f}')} px",
        _number(f["distance_bias_mm"], "{:+.1f} mm"),
        _number(f["distance_p95_mm"], "{:.1f} mm"),
        _share(f["within_2_sigma"]),
    ]


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else form.format(value)


def _share(value: float | None) -> str:
    return _number(None if value is None else 100 * value, "{:.1f} %")
