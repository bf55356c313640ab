# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Plots of an evaluation: what is found and named over the distance, how boxes and distances err, what is confused."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping

import numpy as np

from edgefusion.tools.evaluation import Outcome
from edgefusion.tools.figures import RANGES_M, figures

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")


def plot_all(folder: Path, outcomes: Mapping[str, Outcome]) -> None:
    """range.png, errors.png and confusion.png."""
    _over_range(folder / "range.png", outcomes)
    _errors(folder / "errors.png", outcomes)
    _confusion(folder / "confusion.png", next(iter(outcomes.values())))


def _over_range(path: Path, outcomes: Mapping[str, Outcome]) -> None:
    import matplotlib.pyplot as plt

    names = (("recall", "found"), ("label_accuracy", "named right, of the found"), ("mean_iou", "mean IoU"))
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
    middles = [(least + most) / 2 for least, most in RANGES_M]
    for axis, (key, title) in zip(axes, names):
        for (name, outcome), color in zip(outcomes.items(), COLORS):
            rows = [figures([s for s in outcome.seen if s.free and a <= s.range_m < b])[key] for a, b in RANGES_M]
            values = [np.nan if value is None else value for value in rows]
            axis.plot(middles, values, "o-", color=color, label=name)
        axis.set(title=title, xlabel="distance [m]", ylim=(0, 1.03), xlim=(0.4, 5.1))
        axis.grid(alpha=0.3)
    axes[0].legend(loc="lower left", frameon=False)
    figure.suptitle("free-standing objects")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _errors(path: Path, outcomes: Mapping[str, Outcome]) -> None:
    import matplotlib.pyplot as plt

    panels = (
        ("height_error", "height error [%]", 100.0, np.linspace(-60, 60, 61)),
        ("width_error_px", "width error [px]", 1.0, np.linspace(-30, 30, 61)),
        ("distance_error_m", "distance error [mm]", 1000.0, np.linspace(-60, 60, 61)),
    )
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
    for axis, (field, label, factor, bins) in zip(axes, panels):
        for (name, outcome), color in zip(outcomes.items(), COLORS):
            values = [factor * getattr(s, field) for s in outcome.seen if s.free and s.found]
            if not values:  # no density
                continue
            clipped = np.clip(values, bins[0], bins[-1])
            axis.hist(clipped, bins.tolist(), color=color, alpha=0.55, label=name, density=True)
        axis.set(xlabel=label, yticks=[])
    axes[0].legend(loc="upper left", frameon=False, fontsize=8)
    figure.suptitle("free-standing objects that were found; what is beyond the axis is in its last bar")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _confusion(path: Path, outcome: Outcome) -> None:
    import matplotlib.pyplot as plt

    found = [s for s in outcome.seen if s.free and s.found]
    labels = sorted({s.label for s in found} | {s.said for s in found})
    if not labels:
        return
    counts: Any = np.zeros((len(labels), len(labels)))
    for s in found:
        counts[labels.index(s.label), labels.index(s.said)] += 1
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    side = 2.2 + 0.34 * len(labels)
    figure, axis = plt.subplots(figsize=(side, side), layout="constrained")
    axis.imshow(shares, cmap="Blues", vmin=0, vmax=1)
    axis.set_xticks(range(len(labels)), labels, rotation=60, ha="right", fontsize=8)
    axis.set_yticks(range(len(labels)), labels, fontsize=8)
    for i, j in zip(*np.nonzero(shares >= 0.01)):
        color = "white" if shares[i, j] > 0.5 else "black"
        axis.text(j, i, f"{100 * shares[i, j]:.0f}", ha="center", va="center", fontsize=7, color=color)
    axis.set(xlabel="said", ylabel="is", title="labels of free-standing objects [%]")
    figure.savefig(path, dpi=110)
    plt.close(figure)
