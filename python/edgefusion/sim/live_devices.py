# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""All devices of a robot, simulated from one world and served in real time."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Deque, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.sim.fault_frames import LMS, SIP, Protocol
from edgefusion.sim.fault_pictures import FaultyPictures
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import Fault
from edgefusion.sim.live_camera import LiveCamera, Picture
from edgefusion.sim.live_world import LiveWorld
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.sim.mjpeg_server import MjpegServer
from edgefusion.sim.sip_robot import SipRobot
from edgefusion.sim.sip_robot_character import SH, Character
from edgefusion.sim.wire_device import WireDevice
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.sim.wire_server import WireServer
from edgefusion.sim.wire_tcp import TcpWire
from edgefusion.sim.world import World

FRAME_NS = 50_000_000
"""The camera's period: a child that renders in software keeps up with 20 pictures a second."""

_SHOWN = 100


@dataclass(frozen=True)
class LiveSetup:
    """robot_port, camera_port: 0: any that is free. links: a folder for links to the ptys, `robot` and `laser`.

    laser_left_at: the speed at which an earlier client left the laser streaming. laser_power_up_s: it is off so long.
    """

    world: World
    seed: int = 0
    character: Character = SH
    robot_port: int = 8101
    camera_port: int = 0
    links: Path | None = None
    laser_left_at: int | None = None
    laser_power_up_s: float = 0.0
    camera: bool = True
    faults: Tuple[Fault, ...] = field(default=())


class Shown(NamedTuple):
    """A picture of the camera's: when it was captured, and when it was handed out."""

    stamp_ns: int
    out_ns: int


class LiveDevices:
    """Served from when it is made until it is closed. pump() is to be called every few milliseconds; it never waits.

    shown: the camera's newest pictures: a driver's stamps can be judged by them.
    """

    def __init__(self, setup: LiveSetup, now_ns: int) -> None:
        self._setup = setup
        self._seeds = np.random.SeedSequence(setup.seed)
        self._start_ns = now_ns
        self.shown: Deque[Shown] = deque(maxlen=_SHOWN)
        self._closing: List[PtyWire | TcpWire | LiveCamera | MjpegServer] = []
        try:
            self._serve(setup, now_ns)
        except BaseException:
            self.close()
            raise

    def _serve(self, setup: LiveSetup, now_ns: int) -> None:
        self.world = LiveWorld(setup.world, now_ns, setup.seed)
        self.robot = SipRobot(self.world.body, setup.character, now_ns)
        self.laser = LmsScanner(self.world.scan_at, now_ns, setup.laser_left_at, setup.laser_power_up_s)
        self.robot_pty, self.laser_pty = self._pty(setup, "robot"), self._pty(setup, "laser")
        self.robot_tcp = TcpWire(setup.robot_port)
        self._closing.append(self.robot_tcp)
        self._server = WireServer(
            [
                (self._faulty(self.robot, SIP, "robot", setup, now_ns), (self.robot_pty, self.robot_tcp)),
                (self._faulty(self.laser, LMS, "laser", setup, now_ns), (self.laser_pty,)),
            ]
        )
        self.camera: LiveCamera | None = None
        self.pictures: MjpegServer | None = None
        self._next_frame_ns = now_ns
        if setup.camera:
            self.pictures = MjpegServer(setup.camera_port)
            self._closing.append(self.pictures)
            self.camera = LiveCamera(setup.world, setup.seed)
            self._closing.append(self.camera)
        self._spoilers = [self._spoiler(fault, now_ns) for fault in setup.faults if fault.component == "camera"]

    def _spoiler(self, fault: Fault, now_ns: int) -> FaultyPictures:
        if self.camera is None:
            raise RefusedError(f"fault: camera={fault.kind}: expected a camera, none is served")
        return FaultyPictures(fault, self._rng(), now_ns)

    def _pty(self, setup: LiveSetup, name: str) -> PtyWire:
        wire = PtyWire(None if setup.links is None else setup.links / name)
        self._closing.append(wire)
        return wire

    def _faulty(
        self, device: WireDevice, protocol: Protocol, component: str, setup: LiveSetup, now_ns: int
    ) -> WireDevice:
        for fault in setup.faults:
            if fault.component == component:
                device = FaultyWire(device, protocol, fault, self._rng(), now_ns)
        return device

    def _rng(self) -> np.random.Generator:
        return np.random.default_rng(self._seeds.spawn(1)[0])

    def inject(self, fault: Fault, now_ns: int) -> None:
        """Its times from now on; in place of those that its component has. Raises RefusedError for the camera's where
        none is served."""
        if fault.component == "camera":
            self._spoilers = [self._spoiler(fault, now_ns)]
            return
        devices: Dict[str, Tuple[int, WireDevice, Protocol]] = {
            "robot": (0, self.robot, SIP),
            "laser": (1, self.laser, LMS),
        }
        number, device, protocol = devices[fault.component]
        self._server.replace(number, FaultyWire(device, protocol, fault, self._rng(), now_ns))

    def mend(self) -> None:
        """All are well again."""
        self._server.replace(0, self.robot)
        self._server.replace(1, self.laser)
        self._spoilers = []

    def unplug_laser(self) -> None:
        """Its cable, from the host: its port vanishes, with whatever was under way."""
        self._server.rewire(1)
        self._closing.remove(self.laser_pty)
        self.laser_pty.close()

    def plug_laser(self) -> None:
        """In again: another port, at the same link where there are links."""
        self.laser_pty = self._pty(self._setup, "laser")
        self._server.rewire(1, self.laser_pty)

    def pump(self, now_ns: int) -> None:
        """The world goes on until now, and everything that has left its device by then is carried."""
        self.world.step_to(now_ns)
        self._server.pump(now_ns)
        if self.camera is not None:
            self._expose(self.camera, now_ns)

    def _expose(self, camera: LiveCamera, now_ns: int) -> None:
        body = self.world.body
        if now_ns >= self._next_frame_ns and camera.ask(now_ns, body.pose, body.twist.w_radps):
            self._next_frame_ns = now_ns + FRAME_NS
        pictures: List[Picture] = [picture for picture in [camera.take()] if picture is not None]
        for spoiler in self._spoilers:
            made: Sequence[Optional[Picture]] = pictures or [None]
            pictures = [sent for picture in made for sent in spoiler.sent(picture, now_ns)]
        for picture in pictures:
            if self.pictures is not None:
                self.pictures.put(picture.jpeg, picture.stamp_ns)
                self.shown.append(Shown(picture.stamp_ns, now_ns))

    def close(self) -> None:
        """Takes everything away, as if unplugged."""
        while self._closing:
            self._closing.pop().close()
