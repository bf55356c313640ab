# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Faults of a camera, in real time: a stream over HTTP, read by a child with OpenCV, as on the robot."""

from __future__ import annotations

import threading
import time
from contextlib import suppress
from typing import Callable, List

import cv2
import numpy as np
from benchmarks.fault_row import FaultRow

from edgefusion.clock import system_clock
from edgefusion.config import CameraConfig
from edgefusion.drivers.camera import Camera
from edgefusion.drivers.camera_ring import NoFrameError
from edgefusion.sim.fault_pictures import FaultyPictures
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.live_camera import Picture
from edgefusion.sim.mjpeg_server import MjpegServer

_PERIOD_S, _WAIT_S, _POLL_S, _STARTS_S = 0.05, 20.0, 0.002, 60.0
_OLD_S = 0.2


class _Stream:
    """A camera's URL, served by a thread; fault: what is wrong with it now."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._scene = self._rng.integers(0, 256, (240, 320, 3), np.uint8)
        self.server = MjpegServer()
        self.fault: FaultyPictures | None = None
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.wait(_PERIOD_S):
            now_ns = system_clock()
            noisy = np.clip(self._scene + self._rng.normal(0, 3, self._scene.shape), 0, 255).astype(np.uint8)
            made = Picture(now_ns, cv2.imencode(".jpg", noisy)[1].tobytes())
            fault = self.fault
            for sent in [made] if fault is None else fault.sent(made, now_ns):
                self.server.put(sent.jpeg, sent.stamp_ns)

    def inject(self, text: str) -> float:
        """Returns when, by time.monotonic()."""
        self.fault = FaultyPictures(parse_fault(text), self._rng, system_clock())
        return time.monotonic()

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self.server.close()


def rows(seeds: int, tick: Callable[[], None] = lambda: None) -> List[FaultRow]:
    """tick: called after every camera."""
    lost: List[float] = []
    old: List[float] = []
    back: List[float] = []
    frozen: List[float] = []
    blind: List[float] = []
    hangs: List[float] = []
    for seed in range(seeds):
        _unplugged(seed, lost, old, back)
        frozen.append(_told(seed, "camera=stuck", "CAMERA_FROZEN"))
        blind.append(_told(seed, "camera=wrong", "CAMERA_BLIND"))
        hangs.append(_latest_takes_s(seed))
        tick()
    return [
        FaultRow("C1", "camera unplugged", "CAMERA_LOST in 500 ms", 0.5, lost),
        FaultRow("C1", "age of the last picture that was given", "200 ms", _OLD_S, old),
        FaultRow("C1", "back after it is plugged in", "3 s", 3.0, back),
        FaultRow("C2", "camera frozen", "CAMERA_FROZEN in 1 s", 1.0, frozen),
        FaultRow("C3", "camera covered", "CAMERA_BLIND in 1 s", 1.0, blind),
        FaultRow("C4", "read() hangs: longest call of latest()", "20 ms", 0.02, hangs),
    ]


def runs(seeds: int) -> int:
    """How often rows() calls tick."""
    return seeds


def _camera(stream: _Stream) -> Camera:
    camera = Camera(CameraConfig(source=stream.server.url + "stream"))
    _wait(lambda: camera.health().state.value == "ok", _STARTS_S)
    return camera


def _wait(holds: Callable[[], bool], within_s: float = _WAIT_S) -> float:
    """Until it does; when that is, by time.monotonic(). Raises TimeoutError."""
    deadline_s = time.monotonic() + within_s
    while not holds():
        if time.monotonic() > deadline_s:
            raise TimeoutError("the camera did not come to it")
        time.sleep(_POLL_S)
    return time.monotonic()


def _told(seed: int, fault: str, code: str) -> float:
    stream = _Stream(seed)
    try:
        with _camera(stream) as camera:
            begin_s = stream.inject(fault)
            return _wait(lambda: camera.health().reason.startswith(code)) - begin_s
    finally:
        stream.close()


def _unplugged(seed: int, lost: List[float], old: List[float], back: List[float]) -> None:
    stream = _Stream(seed)
    try:
        with _camera(stream) as camera:
            begin_s, ages = stream.inject("camera=off"), [0.0]

            def is_lost() -> bool:
                with suppress(NoFrameError):
                    ages.append((system_clock() - camera.latest(_OLD_S).stamp_ns) / 1e9)
                return camera.health().reason.startswith("CAMERA_LOST")

            lost.append(_wait(is_lost) - begin_s)
            old.append(max(ages))
            time.sleep(1.0)
            stream.fault, plugged_s = None, time.monotonic()
            back.append(_wait(lambda: camera.health().state.value == "ok") - plugged_s)
    finally:
        stream.close()


def _latest_takes_s(seed: int) -> float:
    """While nothing comes and nothing ends, as from a driver that hangs."""
    stream = _Stream(seed)
    try:
        with _camera(stream) as camera:
            begin_s, longest_s = stream.inject("camera=off"), 0.0
            while time.monotonic() - begin_s < 2.0:
                asked_s = time.monotonic()
                with suppress(NoFrameError):
                    camera.latest(_OLD_S)
                longest_s = max(longest_s, time.monotonic() - asked_s)
                time.sleep(_POLL_S)
            return longest_s
    finally:
        stream.close()
