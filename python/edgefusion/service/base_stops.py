# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who has stopped the base, and how each stop is left: mission and safety gate stand and go on together."""

from __future__ import annotations

from edgefusion.navigation.mission import Mission
from edgefusion.navigation.mission_step import MissionState
from edgefusion.navigation.safety import SafetyGate

_UNDER_WAY = (MissionState.DRIVING, MissionState.INSPECTING)


class Stops:
    """held: since the robot failed, and not by an operator: a new goal is leave enough. ordered: why an operator has
    stopped it; empty once they resumed."""

    def __init__(self, mission: Mission, gate: SafetyGate) -> None:
        self._mission, self._gate = mission, gate
        self._paused = False  # since somebody else drives
        self.held = False
        self.ordered = ""

    def stop(self, reason: str) -> None:
        """An operator's, until they resume. Raises RefusedError for no reason."""
        if self._paused and reason:
            self._mission.resume()  # so that its reason is the worse one
        self._paused = False
        self._mission.stop(reason)
        self._gate.stop(reason)
        self.held = False
        self.ordered = self.ordered or reason

    def pause(self, reason: str) -> None:
        """The mission's alone, while somebody else drives, until they resume."""
        if self._mission.state is not MissionState.STOPPED:
            self._mission.stop(reason)
            self._paused = True

    def hold(self, reason: str) -> None:
        """The robot failed: until there is a new goal, or an operator's leave where an operator has stopped it."""
        if self._mission.state is not MissionState.STOPPED:
            self.held = True
            if self._mission.state in _UNDER_WAY:
                self._mission.stop(reason)
        if self._mission.state is MissionState.STOPPED:
            self._mission.cancel()

    def leave(self) -> None:
        """Whichever it is: the mission's and the gate's, or the gate's alone. Raises RefusedError without one."""
        if self._mission.state is MissionState.STOPPED or not self.held:
            self._mission.resume()
        self._gate.resume()
        self.held = self._paused = False
        self.ordered = ""
