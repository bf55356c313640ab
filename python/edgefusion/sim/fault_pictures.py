# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A camera with which something is wrong for a while."""

from __future__ import annotations

from typing import List

import cv2
import numpy as np

from edgefusion.sim.faults import Fault
from edgefusion.sim.live_camera import Picture

_WHITE, _NOISE = 255, 4


class FaultyPictures:
    """Takes pictures as they are made, gives those that are sent. now_ns: from when its fault's times count."""

    def __init__(self, fault: Fault, rng: np.random.Generator, now_ns: int) -> None:
        self._fault, self._rng, self._start_ns = fault, rng, now_ns
        self._last: Picture | None = None
        self._count = 0
        self._late: List[Picture] = []

    def holds(self, now_ns: int) -> bool:
        """Whether the fault is there now."""
        return self._fault.holds((now_ns - self._start_ns) / 1e9)

    def sent(self, picture: Picture | None, now_ns: int) -> List[Picture]:
        """What is sent now, with the picture that was made just now, if one was."""
        if not self.holds(now_ns):
            self._last = picture or self._last
            self._late.clear()
            return [] if picture is None else [picture]
        if self._fault.kind == "delayed":
            return self._delayed(picture, now_ns)
        return [] if picture is None else self._instead(picture)

    def _delayed(self, picture: Picture | None, now_ns: int) -> List[Picture]:
        if picture is not None:
            self._late.append(picture)
        due = [late for late in self._late if late.stamp_ns + round(self._fault.value * 1e9) <= now_ns]
        del self._late[: len(due)]
        return due

    def _instead(self, picture: Picture) -> List[Picture]:
        kind = self._fault.kind
        if kind == "off":
            return []
        if kind == "stuck":
            self._last = self._last or picture
            return [Picture(picture.stamp_ns, self._last.jpeg)]
        if kind == "garbage":
            return [Picture(picture.stamp_ns, self._noisy(picture.jpeg))]
        if kind == "wrong":
            return [Picture(picture.stamp_ns, self._covered(picture.jpeg))]
        if kind == "slow":
            self._count += 1
            return [picture] if self._count % round(self._fault.value) == 0 else []
        return [] if self._rng.random() < self._fault.value else [picture]

    def _noisy(self, jpeg: bytes) -> bytes:
        data = np.frombuffer(jpeg, np.uint8).copy()
        hit = self._rng.random(len(data)) < self._fault.value
        data[hit] ^= self._rng.integers(1, 256, int(hit.sum()), dtype=np.uint8)
        return data.tobytes()

    def _covered(self, jpeg: bytes) -> bytes:
        """As from behind a cap on the lens, a finger, or in the sun."""
        image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        if image is None:  # another fault has broken it
            return jpeg
        cover = np.full(image.shape, round(_WHITE * self._fault.value), np.uint8)
        if 0 < self._fault.value < 1:  # what is neither black nor burnt out has a sensor's noise
            noise = np.frombuffer(self._rng.bytes(cover.size), np.uint8).reshape(cover.shape) % _NOISE
            cover = np.minimum(cover, _WHITE - _NOISE) + noise
        return bytes(cv2.imencode(".jpg", cover)[1].tobytes())
