# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The plots of a drive's report, as SVG, each for a light and for a dark page."""

from __future__ import annotations

import dataclasses
import io
from dataclasses import dataclass
from typing import Any, Callable

import numpy as np

from edgefusion.errors import RefusedError

NO_MATPLOTLIB = "the report's plots need matplotlib: pip install 'edgefusion[sim]'"


@dataclass(frozen=True)
class Theme:
    """Colours of a plot on a page of one kind; the grounds are the page's own."""

    ink: str
    faint: str
    fill: str
    ground: str
    truth: str
    believed: str
    good: str
    bad: str


# The hues of Okabe and Ito, which colour-blind people tell apart; brighter on a dark page.
LIGHT = Theme("#24292f", "#c9ced6", "#e4e7ec", "#ffffff", "#0072b2", "#d55e00", "#007a5a", "#c0392b")
DARK = Theme("#d7dbe2", "#454b55", "#333842", "#1c1f24", "#56b4e9", "#e69f00", "#2fc79a", "#ff7b6b")

Plot = Callable[[Any, Theme], None]
"""Draws into a figure."""


def check_matplotlib() -> None:
    """Raises RefusedError where matplotlib is missing: before a drive, not after it."""
    try:
        import matplotlib
    except ImportError as error:
        raise RefusedError(NO_MATPLOTLIB) from error
    matplotlib.use("Agg")


def svgs(plot: Plot, size_in: tuple[float, float]) -> list[tuple[str, bytes]]:
    """A plot for both kinds of page: what its file's name ends with, and the SVG."""
    import matplotlib.pyplot as plt

    with plt.rc_context(_style(LIGHT)):
        figure = plt.figure(figsize=size_in, layout="constrained")
        plot(figure, LIGHT)
        buffer = io.BytesIO()
        # Neither date nor random names: the same drive gives the same bytes.
        figure.savefig(buffer, format="svg", metadata={"Date": None}, transparent=True)
        plt.close(figure)
    return [(".svg", buffer.getvalue()), ("-dark.svg", _darkened(buffer.getvalue()))]


def _darkened(svg: bytes) -> bytes:
    """The same plot in the other theme: every colour in it is one of the theme's, so it need not be drawn again."""
    for light, dark in zip(dataclasses.astuple(LIGHT), dataclasses.astuple(DARK)):
        svg = svg.replace(light.encode(), dark.encode())
    return svg


def _style(theme: Theme) -> Any:
    ink = {f"{what}.color": theme.ink for what in ("text", "xtick", "ytick")}
    return {
        **ink,
        "axes.edgecolor": theme.faint,
        "axes.labelcolor": theme.ink,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": theme.faint,
        "grid.alpha": 0.5,
        "grid.linewidth": 0.6,
        "font.size": 10,
        "legend.frameon": False,
        "svg.hashsalt": "edgefusion",
    }


def error_plot(errors_m: Any) -> Plot:
    """Distance errors [n, 3] (true distance, error, sigma) over the distance, and how many sigma they are."""

    def plot(figure: Any, theme: Theme) -> None:
        left, right = figure.subplots(1, 2, gridspec_kw={"width_ratios": (2, 1)})
        left.axhline(0, color=theme.ink, linewidth=0.8)
        left.plot(errors_m[:, 0], 1e3 * errors_m[:, 1], "o", color=theme.truth, markersize=3.5, alpha=0.6)
        left.set(xlabel="true distance [m]", ylabel="error [mm]")
        bins = np.linspace(-4, 4, 25)
        right.axvspan(-2, 2, color=theme.fill, zorder=0)
        right.hist(np.clip(errors_m[:, 1] / errors_m[:, 2], -4, 4), bins.tolist(), color=theme.truth)
        right.set(xlabel="error [sigma]", yticks=[], xticks=[-4, -2, 0, 2, 4])
        right.grid(False)

    return plot
