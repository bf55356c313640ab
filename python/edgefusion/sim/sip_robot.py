# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The firmware of a simulated Pioneer, at the end of its wire: any SIP client can drive it."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional, Tuple

from edgefusion.drivers.sip_command import Command
from edgefusion.drivers.sip_frame import PacketFinder, frame
from edgefusion.sim import sip_robot_packets as packets
from edgefusion.sim.body import Body
from edgefusion.sim.sip_robot_character import SH, Character
from edgefusion.sim.sip_robot_commands import Told, told, wheels_of
from edgefusion.sim.sip_robot_drive import Drive
from edgefusion.sim.wire_line import PacedLine
from edgefusion.types import STILL

BAUDS = (9600, 19200, 38400, 57600, 115200)
"""In the order of HOSTBAUD's argument."""

_MOVE, _ROTATE, _ENCODER, _IOREQUEST, _DCHEAD, _QSTOP = 8, 9, 19, 40, 22, 57
_NS_PER_MS = 1_000_000
_SONAR_MS = 40
_RING = 8
_TURN_COUNTS = 4096
_FULL_DV = 130


class SipRobot:
    """A WireDevice on a body.

    heard: every command that was understood, and when. battery_dv, digital_in, e_stop_pressed: what a test may change.
    """

    def __init__(self, body: Body, character: Character = SH, now_ns: int = 0) -> None:
        self.character, self._body = character, body
        self._line = PacedLine(character.baudrate)
        self.battery_dv, self.digital_in, self.digital_out = _FULL_DV, 0, 0
        self._e_stop = False
        self.heard: List[Tuple[int, Told]] = []
        self._origin = STILL
        self._off_until_ns = 0
        self._reset(now_ns)

    def _reset(self, now_ns: int) -> None:
        """As after power-on."""
        self._line.baudrate = self.character.baudrate
        self._line.clear()
        self._finder = PacketFinder()
        self.open, self._step = False, 0
        self.drive = Drive(self._body, self.character.top_speed_mmps / 1e3, math.radians(self.character.top_turn_dps))
        self._next_status_ns, self._status_ns, self._heard_ns = now_ns, now_ns, now_ns
        self._streams: Dict[int, bool] = {}
        self.sonar = True

    @property
    def line(self) -> PacedLine:
        """Its own end of the line."""
        return self._line

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
        self._reset(now_ns)
        self._body.halt()
        self._origin = self._body.odometry
        self._off_until_ns = now_ns + round(off_s * 1e9)

    def receive(self, data: bytes, baudrate: Optional[int], now_ns: int) -> None:
        """What the host wrote; at another speed than the robot's it understands nothing."""
        if now_ns < self._off_until_ns:
            return
        for packet in self._finder.feed(self._line.heard(data, baudrate)):
            self._heard_ns, self.drive.starving = now_ns, False
            command = told(packet)
            self.heard.append((now_ns, command))
            self._obey(command, now_ns) if self.open else self._shake_hands(command, now_ns)
        self.drive.run()

    def transmit(self, baudrate: Optional[int], now_ns: int) -> bytes:
        """What has left by now."""
        if now_ns < self._off_until_ns:
            return b""
        self._run(now_ns)
        return self._line.heard(self._line.take(now_ns), baudrate)

    def _run(self, now_ns: int) -> None:
        watchdog_ns = self.character.watchdog_ms * _NS_PER_MS
        if self.open and now_ns - self._heard_ns > watchdog_ns:
            self.drive.starving = True
        self.drive.run()
        if self.open and now_ns >= self._next_status_ns:
            cycle_ns = self.character.sip_cycle_ms * _NS_PER_MS
            self._next_status_ns += cycle_ns * (1 + (now_ns - self._next_status_ns) // cycle_ns)
            self._report(now_ns)

    def _shake_hands(self, command: Told, now_ns: int) -> None:
        """0, 1, 2 are the steps; in a synchronized session 1 is OPEN."""
        number = command.number
        if self._step == 3 and number == Command.OPEN:
            self.open, self._next_status_ns, self._status_ns = True, now_ns, now_ns
        elif number == 0:
            self._step = 1
            self._line.put(frame(b"\x00"), now_ns)
        elif number == self._step == 1:
            self._step = 2
            self._line.put(frame(b"\x01"), now_ns)
        elif number == 2 and self._step in (2, 3):
            self._step = 3
            self._line.put(packets.identity(self.character), now_ns)
        elif number in (1, 2):
            self._step = 0
            self._line.put(packets.OUT_OF_STEP, now_ns)

    def _close(self) -> None:
        self.drive.stop()
        self.drive.motors = False
        self.open, self._step = False, 0
        self._streams.clear()
        if self.character.autobaud == 2:
            self._line.baudrate = self.character.baudrate

    def _obey(self, command: Told, now_ns: int) -> None:
        number, value, drive = command.number, command.value, self.drive
        actions: Dict[int, Callable[[], None]] = {
            Command.CLOSE: self._close,
            Command.ENABLE: lambda: self._enable(command.on),
            Command.SETV: lambda: setattr(drive, "top_speed_mps", min(value, self.character.top_speed_mmps) / 1e3),
            Command.SETRV: lambda: setattr(
                drive, "top_yaw_rate_radps", math.radians(min(value, self.character.top_turn_dps))
            ),
            Command.SETO: self._set_origin,
            _MOVE: lambda: drive.move(value / 1e3),
            _ROTATE: lambda: drive.set_turn(math.radians(value)),
            Command.VEL: lambda: drive.set_speed(value / 1e3),
            Command.RVEL: lambda: drive.set_turn(math.radians(value)),
            Command.VEL2: lambda: drive.set_wheels(*(0.02 * steps for steps in wheels_of(value))),
            Command.HEAD: lambda: drive.turn_to(self._origin.theta + math.radians(value)),
            Command.DHEAD: lambda: drive.turn_by(math.radians(value)),
            _DCHEAD: lambda: drive.turn_by(math.radians(value)),
            Command.STOP: drive.stop,
            Command.E_STOP: drive.halt,
            _QSTOP: drive.halt,
            Command.SONAR: lambda: setattr(self, "sonar", command.on),
            Command.DIGOUT: lambda: self._set_outputs(value),
            Command.CONFIG: lambda: self._send_parameters(now_ns),
            Command.HOSTBAUD: lambda: self._set_speed(value),
            _ENCODER: lambda: self._stream(number, value, now_ns),
            _IOREQUEST: lambda: self._stream(number, value, now_ns),
        }
        actions.get(number, _ignore)()

    def _enable(self, on: bool) -> None:
        self.drive.motors = on and not self._e_stop
        if not on:
            self.drive.stop()

    def _set_origin(self) -> None:
        self._origin = self._body.odometry

    def _set_outputs(self, value: int) -> None:
        mask, values = value >> 8 & 0xFF, value & 0xFF
        self.digital_out = self.digital_out & ~mask | values & mask

    def _set_speed(self, value: int) -> None:
        if 0 <= value < len(BAUDS):
            self._line.clear()
            self._line.baudrate = BAUDS[value]

    def _send_parameters(self, now_ns: int) -> None:
        if self.character.config_packet != "missing":
            self._line.put(packets.parameters(self.character), now_ns)

    def _stream(self, number: int, value: int, now_ns: int) -> None:
        """0: no longer, 1: once, 2: with every SIP."""
        self._streams[number] = value == 2
        if value == 1:
            self._send_extra(number, now_ns)

    def _send_extra(self, number: int, now_ns: int) -> None:
        if number == _IOREQUEST:
            self._line.put(packets.io((self.digital_in, self.digital_out), self._bumpers()), now_ns)
            return
        x, _, heading = self._counts()
        self._line.put(packets.encoders(x - heading, x + heading), now_ns)

    def _report(self, now_ns: int) -> None:
        twist = self._body.twist
        aside_mmps = twist.w_radps / 0.0056
        wheels = round(twist.v_mps * 1e3 - aside_mmps), round(twist.v_mps * 1e3 + aside_mmps)
        self._line.put(
            packets.status(
                self._counts(),
                wheels,
                round(math.degrees(twist.w_radps) * 10),
                self.battery_dv,
                self._body.stalled,
                self._bumpers(),
                self.drive.motors,
                self._e_stop,
                self.sonar,
                self._fired(now_ns) if self.sonar else (),
                (self.digital_in, self.digital_out),
            ),
            now_ns,
        )
        self._status_ns = now_ns
        for number, streams in self._streams.items():
            if streams:
                self._send_extra(number, now_ns)

    def _counts(self) -> Tuple[int, int, int]:
        pose, mask = self._body.odometry.relative_to(self._origin), (1 << self.character.counter_bits) - 1
        x, y = (round(metres * 1e3 / self.character.distance_mm) & mask for metres in (pose.x_m, pose.y_m))
        half = _TURN_COUNTS // 2
        heading = (round(pose.theta * _TURN_COUNTS / (2 * math.pi)) + half) % _TURN_COUNTS - half
        return x, y, heading

    def _bumpers(self) -> Tuple[int, int]:
        front, rear = (sum(pressed << i for i, pressed in enumerate(side)) for side in self._body.bumpers)
        return front, rear

    def _fired(self, now_ns: int) -> List[Tuple[int, int]]:
        """One sonar of either ring every 40 ms, in turn."""
        slot_ns = _SONAR_MS * _NS_PER_MS
        slots = range(self._status_ns // slot_ns, now_ns // slot_ns)
        numbers = [first + slot % _RING for slot in slots[-_RING:] for first in range(0, self.character.sonars, _RING)]
        return [(number, _range_mm(self._body.sonar_m(number))) for number in sorted(set(numbers))]


def _range_mm(range_m: float) -> int:
    return packets.NOTHING_COUNTS if range_m * 1e3 >= packets.NOTHING_COUNTS else round(range_m * 1e3)


def _ignore() -> None:
    """What a real one does with a command that it does not know."""
