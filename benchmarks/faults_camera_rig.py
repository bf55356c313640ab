# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A camera on the network with which something can go wrong, and the real driver that reads it, in its own process."""

from __future__ import annotations

import math
import threading
import time
from pathlib import Path
from typing import Callable, List

import cv2
import numpy as np

from edgefusion.clock import system_clock
from edgefusion.config.camera import CameraConfig
from edgefusion.drivers.camera import Camera
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.sim.fault_pictures import FaultyPictures
from edgefusion.sim.faults import Fault, parse_fault
from edgefusion.sim.live_camera import Picture
from edgefusion.sim.mjpeg_server import MjpegServer
from edgefusion.types import HealthState

MAX_AGE_S = 0.2
"""Older pictures are not looked at."""

_PERIOD_S, _POLL_S, _PATIENCE_S = 0.05, 0.005, 30.0
_WIDTH, _HEIGHT, _FILM = 640, 480, 20
_WELL = Fault("camera", "off", 0.0, math.inf)


class CameraRig:
    """Well and seen from entering to leaving, until something is injected. seed: of the pictures and of the faults.

    oldest_s: the greatest age of a picture that the driver gave.
    """

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._film = _film(self._rng)
        self._lock, self._over = threading.Lock(), threading.Event()
        self._spoiler = FaultyPictures(_WELL, self._rng, system_clock())
        self._server: MjpegServer | None = MjpegServer()
        self.url = self._server.url + "stream"
        self._port = int(self._server.url.rstrip("/").rsplit(":", 1)[1])
        self._feeder = threading.Thread(target=self._feed)
        self.camera = Camera(CameraConfig(source=self.url))
        self.oldest_s = 0.0

    def __enter__(self) -> CameraRig:
        self._feeder.start()
        try:
            self.wait_for(lambda: self.is_well)
        except BaseException:
            self.__exit__()
            raise
        time.sleep(_PERIOD_S * self._rng.random())
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._feeder.join()
        self.camera.close()
        self.unplug()

    @property
    def is_well(self) -> bool:
        """Whether the driver says so."""
        return self.camera.health().state is HealthState.OK

    def says(self, code: str) -> bool:
        """Whether that is what the driver says of it."""
        return self.camera.health().reason.startswith(code)

    def inject(self, fault: str) -> None:
        """As `camera=stuck`, from now on."""
        with self._lock:
            self._spoiler = FaultyPictures(parse_fault(fault), self._rng, system_clock())

    def mend(self) -> None:
        """It is well again."""
        with self._lock:
            self._spoiler = FaultyPictures(_WELL, self._rng, system_clock())

    def unplug(self) -> None:
        """It is gone from the network."""
        with self._lock:
            server, self._server = self._server, None
        if server is not None:
            server.close()

    def plug(self) -> None:
        """It is where it was."""
        with self._lock:
            self._server = MjpegServer(self._port)

    def wait_for(self, holds: Callable[[], bool]) -> float:
        """How long it takes [s]; meanwhile pictures are asked for. Raises TimeoutError."""
        begin_s = time.monotonic()
        while not holds():
            self.ask()
            if time.monotonic() - begin_s > _PATIENCE_S:
                raise TimeoutError(f"{self.url}: it did not come to it: {self.camera.health()}")
            time.sleep(_POLL_S)
        return time.monotonic() - begin_s

    def given_within(self, seconds: float) -> int:
        """How often a picture was to be had in so long."""
        given, end_s = 0, time.monotonic() + seconds
        while time.monotonic() < end_s:
            given += self.ask()
            time.sleep(_POLL_S)
        return given

    def ask(self) -> bool:
        """Whether there is a picture to look at."""
        try:
            frame = self.camera.latest(MAX_AGE_S)
        except NoFrameError:
            return False
        self.oldest_s = max(self.oldest_s, (system_clock() - frame.stamp_ns) / 1e9)
        return True

    def _feed(self) -> None:
        number = 0
        while not self._over.wait(_PERIOD_S):
            number += 1
            now_ns = system_clock()
            with self._lock:
                for picture in self._spoiler.sent(Picture(now_ns, self._film[number % len(self._film)]), now_ns):
                    if self._server is not None:
                        self._server.put(picture.jpeg, picture.stamp_ns)


def capturing() -> List[int]:
    """The ids of this process's children that capture."""
    children = [int(pid) for path in Path("/proc/self/task").glob("*/children") for pid in path.read_text().split()]
    return [pid for pid in children if "camera_capture" in Path(f"/proc/{pid}/cmdline").read_text()]


def _film(rng: np.random.Generator) -> List[bytes]:
    """JPEGs of tiles, no two alike: each with other noise."""
    tiles = rng.integers(0, 240, (6, 8, 3), dtype=np.uint8)
    image = cv2.resize(tiles, (_WIDTH, _HEIGHT), interpolation=cv2.INTER_NEAREST)
    noise = rng.integers(0, 8, (_FILM, *image.shape), dtype=np.uint8)
    return [cv2.imencode(".jpg", image + one)[1].tobytes() for one in noise]
