# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""How a host gets into a session with a simulated Pioneer: three steps, then OPEN."""

from __future__ import annotations

from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import frame
from edgefusion.sim import sip_robot_packets as packets
from edgefusion.sim.sip_robot_character import Character


class Handshake:
    """done: the session is open. Step 1 has the number of OPEN, which is that in a synchronized session only."""

    def __init__(self, character: Character) -> None:
        self._character, self._step = character, 0
        self.done = False

    def answer(self, number: int) -> bytes:
        """What is said to a command. A step that is said again is answered again: its answer may have been lost.

        Before the first step nothing is out of turn: a host that closes what is closed gets no answer.
        """
        if self._step == 3 and number == Command.OPEN:
            self.done = True
            return b""
        if number > 2 or (number and not self._step):
            return b""
        if number and self._step not in (number, number + 1):
            self._step = 0
            return packets.OUT_OF_STEP if self._character.says_out_of_step else b""
        self._step = number + 1
        return packets.identity(self._character) if number == 2 else frame(bytes([number]))
