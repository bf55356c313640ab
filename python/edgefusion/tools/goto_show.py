# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a drive goes, as its operator sees it: in place in a terminal, else a line when something changes."""

from __future__ import annotations

import sys
from typing import Callable

import msgspec

from edgefusion.bus.client import ENDS
from edgefusion.messages.mission_report import MissionReport
from edgefusion.tools.mission_words import inspection_in_words, mission_in_words, pose_in_words
from edgefusion.tools.terminal import Screen

STOPPED = "stopped"
Show = Callable[[MissionReport], None]


def shown(as_json: bool) -> Show:
    """What shows each report."""
    if as_json:
        return _show_json
    return _InPlace().show if sys.stdout.isatty() else _Changes().show


def _show_json(report: MissionReport) -> None:
    print(msgspec.json.encode(report).decode(), flush=True)


class _InPlace:
    """What was inspected, and how it is now."""

    def __init__(self) -> None:
        self._screen = Screen(sys.stdout)
        self._inspected: list[str] = []

    def show(self, report: MissionReport) -> None:
        if report.result is not None:
            self._inspected.append(inspection_in_words(report.result))
        now = [f"mission  {mission_in_words(report)}", f"pose     {pose_in_words(report.pose)}"]
        self._screen.show([*self._inspected, *now, *_what_to_press(report.state)])


def _what_to_press(state: str) -> list[str]:
    if state in ENDS:
        return []
    goes_on = ["`edgefusion resume` in another terminal lets it drive on"] if state == STOPPED else []
    return [*goes_on, "Ctrl-C gives the goal up and stops the robot"]


class _Changes:
    """A driving robot's notes come and go with every obstacle: they are no change."""

    def __init__(self) -> None:
        self._said = ("", "", "")

    def show(self, report: MissionReport) -> None:
        if report.result is not None:
            print(inspection_in_words(report.result), flush=True)
        said = (report.state, report.reason, report.goal_id)
        if said != self._said:
            self._said = said
            print(f"{mission_in_words(report)}, at {pose_in_words(report.pose)}", flush=True)
