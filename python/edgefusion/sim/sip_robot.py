# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The firmware of a simulated Pioneer, at the end of its wire: any SIP client can drive it."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional, Tuple

from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import PacketFinder
from edgefusion.sim import sip_robot_packets as packets
from edgefusion.sim.body import Body
from edgefusion.sim.sip_robot_character import SH, Character
from edgefusion.sim.sip_robot_commands import Told, told, wheels_of
from edgefusion.sim.sip_robot_drive import Drive
from edgefusion.sim.sip_robot_handshake import Handshake
from edgefusion.sim.sip_robot_ramp import Ramp
from edgefusion.sim.sip_robot_reports import ENCODER, IOREQUEST, Reports
from edgefusion.sim.wire_line import PacedLine

BAUDS = (9600, 19200, 38400, 57600, 115200)
"""In the order of HOSTBAUD's argument."""

_POLLING, _MOVE, _ROTATE, _DCHEAD, _SONARCYCLE, _QSTOP = 3, 8, 9, 22, 48, 57
_NS_PER_MS = 1_000_000
_REMEMBERED = 20_000


class SipRobot:
    """A WireDevice on a body.

    heard: the newest commands that were understood, and when. reports: battery and digital lines, which a test may
    change. drive.motors, e_stop_pressed: so may these.
    """

    def __init__(self, body: Body, character: Character = SH, now_ns: int = 0) -> None:
        self.character, self._body = character, body
        self._line = PacedLine(character.baudrate)
        self.reports = Reports(body, character, now_ns)
        self._e_stop = False
        self.heard: List[Tuple[int, Told]] = []
        self._off_until_ns = now_ns
        self._reset(now_ns)

    def _reset(self, now_ns: int) -> None:
        """As after power-on."""
        c = self.character
        self._line.baudrate = c.baudrate
        self._line.clear()
        self._finder = PacketFinder()
        self._handshake = Handshake(c)
        speed = Ramp(c.top_speed_mmps / 1e3, c.top_speed_mmps2 / 1e3)
        self.drive = Drive(self._body, speed, Ramp(math.radians(c.top_turn_dps), math.radians(c.top_turn_dps2)), now_ns)
        self._next_status_ns = self._heard_ns = now_ns
        self._stall_on_bump, self._bumped = 0, False

    @property
    def line(self) -> PacedLine:
        """Its own end of the line."""
        return self._line

    @property
    def open(self) -> bool:
        """Whether a session is: until then it reports nothing and obeys nothing."""
        return self._handshake.done

    @property
    def e_stop_pressed(self) -> bool:
        """The button: it switches the motors off, and letting it go does not switch them on."""
        return self._e_stop

    @e_stop_pressed.setter
    def e_stop_pressed(self, pressed: bool) -> None:
        self._e_stop = pressed
        if pressed:
            self.drive.motors = False
            self.drive.halt()

    def power_cycle(self, now_ns: int, off_s: float = 0.5) -> None:
        """Off, and on again after a while, as it was when it was new: closed, motors off, its counts at 0."""
        self._off_until_ns = now_ns + round(off_s * 1e9)
        self._body.halt()
        self._reset(self._off_until_ns)
        self.reports.reset(self._off_until_ns)

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        """What the host wrote; at another speed than the robot's it understands nothing."""
        if now_ns < self._off_until_ns:
            return
        for packet in self._finder.feed(self._line.heard(data, baudrate)):
            self._heard_ns, self.drive.starving = now_ns, False
            command = told(packet)
            self._remember(now_ns, command)
            self._obey(command, now_ns) if self.open else self._shake_hands(command, now_ns)
        self.drive.run(now_ns)

    def _remember(self, now_ns: int, command: Told) -> None:
        self.heard.append((now_ns, command))
        if len(self.heard) > _REMEMBERED:
            del self.heard[: _REMEMBERED // 2]

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        """What has left by now."""
        if now_ns < self._off_until_ns:
            return b""
        self._run(now_ns)
        return self._line.heard(self._line.take(now_ns), baudrate)

    def _run(self, now_ns: int) -> None:
        if self.open and now_ns - self._heard_ns > self.character.watchdog_ms * _NS_PER_MS:
            self.drive.starving = True
        bumped = self._is_bumped()
        if bumped and not self._bumped:
            self.drive.stop()
        self._bumped = bumped
        self.drive.run(now_ns)
        self.reports.wheels.roll_to(self._body.odometry)
        if self.open and now_ns >= self._next_status_ns:
            cycle_ns = self.character.sip_cycle_ms * _NS_PER_MS
            self._next_status_ns += cycle_ns * (1 + (now_ns - self._next_status_ns) // cycle_ns)
            left, right = self._body.stalled
            stalled = left or bumped, right or bumped
            self._line.put(self.reports.due(now_ns, self.drive.motors, self._e_stop, stalled), now_ns)

    def _is_bumped(self) -> bool:
        """Where it is to take that for a stall: bit 0 at the front, bit 1 at the back."""
        front, rear = self.reports.bumpers()
        return bool((self._stall_on_bump & 1 and front) or (self._stall_on_bump & 2 and rear))

    def _shake_hands(self, command: Told, now_ns: int) -> None:
        self._line.put(self._handshake.answer(command.number), now_ns)
        self._next_status_ns = now_ns + self.character.sip_cycle_ms * _NS_PER_MS  # after OPEN

    def _close(self) -> None:
        self.drive.stop()
        self.drive.motors = False
        self._handshake = Handshake(self.character)
        self.reports.end()
        self._line.clear()
        if self.character.autobaud == 2:
            self._line.baudrate = self.character.baudrate

    def _obey(self, command: Told, now_ns: int) -> None:
        number, value, drive = command.number, command.value, self.drive
        actions: Dict[int, Callable[[], None]] = {
            Command.CLOSE: self._close,
            _POLLING: lambda: self.reports.sonars.poll(command.text),
            Command.ENABLE: lambda: self._enable(command.on),
            Command.SETA: lambda: drive.speed.set_rate(value / 1e3),
            Command.SETV: lambda: drive.speed.set_top(value / 1e3),
            Command.SETO: self.reports.set_origin,
            _MOVE: lambda: drive.move(value / 1e3),
            _ROTATE: lambda: drive.set_turn(math.radians(value)),
            Command.SETRV: lambda: drive.turn.set_top(math.radians(value)),
            Command.VEL: lambda: drive.set_speed(value / 1e3),
            Command.HEAD: lambda: drive.turn_to(self.reports.origin.theta + math.radians(value)),
            Command.DHEAD: lambda: drive.turn_by(math.radians(value)),
            Command.CONFIG: lambda: self._send_parameters(now_ns),
            ENCODER: lambda: self._line.put(self.reports.stream(number, value), now_ns),
            Command.RVEL: lambda: drive.set_turn(math.radians(value)),
            _DCHEAD: lambda: drive.turn_on_by(math.radians(value)),
            Command.SETRA: lambda: drive.turn.set_rate(math.radians(value)),
            Command.SONAR: lambda: setattr(self.reports.sonars, "on", command.on),
            Command.STOP: drive.stop,
            Command.DIGOUT: lambda: self.reports.set_outputs(value >> 8 & 0xFF, value & 0xFF),
            Command.VEL2: lambda: drive.set_wheels(*(0.02 * steps for steps in wheels_of(value))),
            IOREQUEST: lambda: self._line.put(self.reports.stream(number, value), now_ns),
            Command.BUMPSTALL: lambda: setattr(self, "_stall_on_bump", value),
            _SONARCYCLE: lambda: self.reports.sonars.set_period(value),
            Command.HOSTBAUD: lambda: self._set_speed(value),
            Command.E_STOP: drive.halt,
            _QSTOP: drive.halt,
        }
        actions.get(number, _ignore)()

    def _enable(self, on: bool) -> None:
        self.drive.motors = on and not self._e_stop
        if not on:
            self.drive.stop()

    def _set_speed(self, value: int) -> None:
        if 0 <= value < len(BAUDS):
            self._line.clear()
            self._line.baudrate = BAUDS[value]

    def _send_parameters(self, now_ns: int) -> None:
        if self.character.config_packet != "missing":
            self._line.put(packets.parameters(self.character), now_ns)


def _ignore() -> None:
    """What a real one does with a command that it does not know."""
