# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How well vision sees, and what that takes. Pure: the time is passed in."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Deque, Dict, Mapping

import numpy as np

from edgefusion.drivers.camera_state import STARTING as CAMERA_STARTING
from edgefusion.service.vision_look import Look
from edgefusion.types import Health, HealthState

COMPONENT = "detector"
"""`vision` is what the supervisor calls the process."""

PATIENCE_NS = 2_000_000_000
"""The slowest scanner gives two scans a second."""

_KEPT = 50


@dataclass(frozen=True)
class Circumstances:
    """trouble: why nothing is seen now, of the camera or its frames. refused: why scans do not count. note: why the
    network does not run on what it was to run on. Each is empty where there is none."""

    trouble: str = ""
    refused: str = ""
    note: str = ""


class VisionState:
    """Told of every scan and look; start_ns: from when both are waited for."""

    def __init__(self, start_ns: int, tolerance_s: float) -> None:
        self._scan_ns = self._since_ns = start_ns
        self._tolerance_s = tolerance_s
        self._looks: Deque[Look] = deque(maxlen=_KEPT)
        self._figures: Mapping[str, str] | None = {}  # None: to be worked out anew

    def scanned(self, now_ns: int) -> None:
        """A scan came."""
        if now_ns - self._scan_ns > PATIENCE_NS:
            self._wait_anew(now_ns)
        self._scan_ns = now_ns

    def looked(self, look: Look) -> None:
        """The detector has looked."""
        self._scan_ns = self._since_ns = look.ended_ns
        self._looks.append(look)
        self._figures = None

    def health(self, now_ns: int, so: Circumstances) -> Health:
        """With the reason by which somebody can help."""
        state, reason = self._judged(now_ns, so)
        return Health(COMPONENT, state, reason)

    def _judged(self, now_ns: int, so: Circumstances) -> tuple[HealthState, str]:
        if so.trouble:
            self._wait_anew(now_ns)
            state = HealthState.STARTING if so.trouble.startswith(CAMERA_STARTING) else HealthState.FAILED
            return state, f"sees nothing: {so.trouble}"
        if now_ns - self._scan_ns > PATIENCE_NS:
            return HealthState.FAILED, self._no_scans(now_ns, so)
        if now_ns - self._since_ns > PATIENCE_NS:
            apart = f"none within sync.tolerance_s = {self._tolerance_s:g} s of each other"
            return HealthState.FAILED, f"NO_PAIRS: scans and frames come, but {apart}"
        if not self._looks:
            return HealthState.STARTING, "waits for a scan and a frame"
        if so.note:
            return HealthState.DEGRADED, so.note
        if self._looks[-1].pose is None:
            return HealthState.DEGRADED, "NO_ODOMETRY: how the robot moves between scan and frame is not known"
        return HealthState.OK, ""

    def _wait_anew(self, now_ns: int) -> None:
        """For scans and frames that meet; before, none could."""
        self._since_ns = now_ns
        self._looks.clear()
        self._figures = {}

    def _no_scans(self, now_ns: int, so: Circumstances) -> str:
        if so.refused:
            return f"SCANS_REFUSED: {so.refused}"
        return f"NO_SCANS: none for {(now_ns - self._scan_ns) / 1e9:.0f} s: is base running, and its laser well?"

    def figures(self) -> Mapping[str, str]:
        """Medians of the newest looks, each with its unit."""
        if self._figures is None:
            self._figures = self._medians()
        return self._figures

    def _medians(self) -> Mapping[str, str]:
        looks = tuple(self._looks)
        stages = ("cluster", "crop", "infer", "vote")
        figures: Dict[str, str] = {
            f"{stage} [ms]": _median_ms([getattr(look.times, f"{stage}_ns") for look in looks]) for stage in stages
        }
        figures["age when begun [ms]"] = _median_ms([look.begun_ns - look.frame.stamp_ns for look in looks])
        figures["age when known [ms]"] = _median_ms([look.age_ns for look in looks])
        figures["frames [Hz]"] = f"{self.rate_hz:.1f}"
        return figures

    @property
    def rate_hz(self) -> float:
        """Of the looks."""
        if len(self._looks) < 2:
            return 0.0
        return (len(self._looks) - 1) * 1e9 / (self._looks[-1].ended_ns - self._looks[0].ended_ns)


def _median_ms(values_ns: list[int]) -> str:
    return f"{float(np.median(values_ns)) / 1e6:.1f}"
