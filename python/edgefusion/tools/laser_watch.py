# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Scans as they come: as text, as lines of JSON, as a plot in the terminal or in a file."""

from __future__ import annotations

import json
import math
import re
import shutil
import sys
import time
from pathlib import Path

import numpy as np

from edgefusion.clock import Clock
from edgefusion.drivers.backoff import Backoff
from edgefusion.drivers.link import LinkError
from edgefusion.drivers.lms2xx import Lms2xx
from edgefusion.tools.scan_plot import ROWS, scan_lines, scan_picture
from edgefusion.tools.terminal import Screen
from edgefusion.types import Scan

_REDRAWN_NS, _PAUSE_S = 500_000_000, 0.01
_UNITS = {0: "cm", 1: "mm"}


class LaserWatch:
    """png: where the last scan is drawn into. live: whether a plot is drawn anew in the terminal.

    What is told but no scan goes to the terminal's errors, so that what reads the scans is not disturbed.
    """

    def __init__(self, png: Path | None, as_json: bool, live: bool) -> None:
        self._png, self._json, self._live = png, as_json, live
        self._last: Scan | None = None
        self._first_ns = 0
        self._count = 0
        self._screen = Screen(sys.stdout)
        self._drawn_ns = -_REDRAWN_NS
        self._said = ""

    def begin(self, laser: Lms2xx, baudrate: int) -> None:
        """What is connected."""
        status = laser.status
        self._said = _said(laser)
        if self._json or status is None:
            return
        variant = status.variant
        unit = _UNITS.get(status.unit, "?")
        print(f"type:    {laser.model or 'it does not say'}")
        print(f"speed:   {baudrate} baud")
        print(f"scan:    {variant.angle} degrees, every {variant.resolution / 100:g}")
        print(f"ranges:  measuring mode {status.measuring_mode}, in {unit}")
        print(f"health:  {self._said}", flush=True)

    def show(self, scan: Scan, laser: Lms2xx) -> None:
        """The newest scan."""
        self._count += 1
        if self._last is None:
            self._first_ns = scan.stamp_ns
        self._last = scan
        if self._json:
            print(_as_json(scan, laser), flush=True)

    def tell(self, laser: Lms2xx, now_ns: int) -> None:
        """How it is: with the plot, drawn anew now and then, or as a line when it changes."""
        before, self._said = self._said, _said(laser)
        changed = _wordy(self._said) != _wordy(before)
        if not self._live:
            if changed:
                print(f"health:  {self._said}", file=sys.stderr, flush=True)
        elif self._last is not None and (changed or now_ns - self._drawn_ns >= _REDRAWN_NS):
            self._drawn_ns = now_ns
            self._screen.show([*scan_lines(self._last, _rows()), f"{self._summary()}; {self._said}"])

    def end(self) -> None:
        """What there was in all. The picture, where one is wanted."""
        if self._last is None:
            return
        if self._live and self._drawn_ns < 0:
            print("\n".join(scan_lines(self._last, _rows())))
        if self._png is not None:
            scan_picture(self._last, self._png)
            print(f"picture: {self._png}", file=sys.stderr if self._json else sys.stdout)
        if not self._json:
            print(self._summary())

    @property
    def has_scan(self) -> bool:
        """Whether there was one."""
        return self._last is not None

    @property
    def rate_hz(self) -> float:
        """Scans a second, so far; 0 before the second."""
        span_ns = 0 if self._last is None else self._last.stamp_ns - self._first_ns
        return (self._count - 1) * 1e9 / span_ns if span_ns > 0 else 0.0

    def _summary(self) -> str:
        scan = self._last
        if scan is None:
            return "no scan"
        seen = np.isfinite(scan.ranges_m)
        nearest = f"nearest {scan.ranges_m[seen].min():.2f} m" if seen.any() else "nothing near"
        rate = f"{self.rate_hz:.1f} Hz, " if self.rate_hz else ""
        free, unknown = int(np.isposinf(scan.ranges_m).sum()), int(np.isnan(scan.ranges_m).sum())
        return f"scans:   {self._count}, {rate}{len(seen)} beams: {free} free, {unknown} unknown, {nearest}"


def watch(laser: Lms2xx, shown: LaserWatch, once: bool, seconds: float, clock: Clock) -> None:
    """Until so long has passed, or once there was a scan; a scanner that was lost is searched again.

    Raises RefusedError; LinkError where it is lost before the one scan.
    """
    end_ns, backoff = clock() + seconds * 1e9, Backoff()
    while clock() < end_ns:
        try:
            for scan in _scans(laser, backoff.due(clock())):
                backoff.reset()
                shown.show(scan, laser)
                if once:
                    return
        except LinkError:
            if once:
                raise
            backoff.failed(clock())
        shown.tell(laser, clock())


def _scans(laser: Lms2xx, may_start: bool) -> list[Scan]:
    """What came within some 20 ms; a search takes seconds."""
    if laser.status is not None:
        return laser.read()
    if may_start:
        laser.start()
    else:
        time.sleep(_PAUSE_S)
    return []


def _rows() -> int:
    """As many as fit into the terminal, four columns to each."""
    size = shutil.get_terminal_size()
    return max(1, min(ROWS, size.lines - 3, size.columns // 4))


def _wordy(said: str) -> str:
    """Without its numbers, which change all the time."""
    return re.sub(r"[\d.]+", "", said)


def _said(laser: Lms2xx) -> str:
    health = laser.health
    return f"{health.state.value}: {health.reason}" if health.reason else health.state.value


def _as_json(scan: Scan, laser: Lms2xx) -> str:
    """inf as null would hide that a beam is free: it is written as a string, as NaN is."""
    ranges = [round(float(r), 3) if math.isfinite(r) else str(float(r)) for r in scan.ranges_m]
    return json.dumps(
        {
            "stamp_ns": scan.stamp_ns,
            "angle_min": scan.angle_min,
            "angle_increment": scan.angle_increment,
            "range_max_m": round(scan.range_max_m, 3),
            "health": _said(laser),
            "ranges_m": ranges,
        }
    )
