# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The folder of `edgefusion evaluate`: figures.json, figures.md, plots, and pictures of what went wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping, Sequence

import cv2
import msgspec

from edgefusion.config import PerceptionConfig
from edgefusion.errors import RefusedError
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.clusters import find_clusters
from edgefusion.tools.draw import annotate
from edgefusion.tools.evaluation import Look, Outcome, Watcher
from edgefusion.tools.measure import Seen
from edgefusion.types import Detection

FAILURES = 24
"""Pictures of frames in which something that counts went wrong, at most."""

POOR_IOU = 0.5
_HEAD = (
    "objects", "recall", "label", "IoU", "height error, median / p95", "width error, median / p95",
    "distance bias", "distance p95", "within 2 sigma",
)  # fmt: skip


class EvaluationFolder:
    """Where the results go. Raises RefusedError where some lie already and may not be replaced."""

    def __init__(self, path: Path, overwrite: bool, calibration: Calibration) -> None:
        self.path, self._calibration, self._kept = path, calibration, 0
        if (path / "figures.json").exists() and not overwrite:
            raise RefusedError(f"{path / 'figures.json'}: exists already; --overwrite replaces it, --out takes another")
        for old in (path / "failures").glob("*.jpg"):
            old.unlink()

    def keep_failures(self, setting: str) -> Watcher:
        """Keeps pictures of one setting's failures as they come."""

        def watch(name: str, look: Look, detections: Sequence[Detection], seen: Sequence[Seen]) -> None:
            wrong = [each for each in seen if each.free and not _well(each)]
            if name != setting or not wrong or self._kept >= FAILURES:
                return
            self._kept += 1
            self._draw(look, detections, wrong)

        return watch

    def write(self, report: dict[str, Any], outcomes: Mapping[str, Outcome]) -> str:
        """Everything; returns the table as Markdown."""
        from edgefusion.tools.evaluation_plots import plot_all

        self.path.mkdir(parents=True, exist_ok=True)
        table = markdown(report)
        (self.path / "figures.json").write_text(self.json(report) + "\n", encoding="utf-8")
        (self.path / "figures.md").write_text(table + "\n", encoding="utf-8")
        plot_all(self.path, outcomes)
        return table

    @staticmethod
    def json(report: dict[str, Any]) -> str:
        """The figures for a program."""
        return msgspec.json.format(msgspec.json.encode(report), indent=2).decode()

    def _draw(self, look: Look, detections: Sequence[Detection], wrong: Sequence[Seen]) -> None:
        clusters = find_clusters(look.shot.scan, PerceptionConfig())
        picture = annotate(look.shot.frame.image, detections, look.shot.scan, clusters, self._calibration)
        for i, each in enumerate(wrong):
            line = f"{each.kind} at {each.range_m:.1f} m: " + (
                f"called {each.said}, IoU {each.iou:.2f}" if each.found else "not found"
            )
            cv2.putText(picture, line, (6, 18 + 18 * i), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 3, cv2.LINE_AA)
            cv2.putText(picture, line, (6, 18 + 18 * i), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA)
        folder = self.path / "failures"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{look.number:05d}.jpg").write_bytes(cv2.imencode(".jpg", picture)[1].tobytes())


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
        first = next(iter(settings.values()))
        lines += ["", _row((f"free-standing, {title}", *_HEAD)), _row(["---"] * (len(_HEAD) + 1))]
        lines += [_row((name, *cells(each))) for name, each in first[key].items()]
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
