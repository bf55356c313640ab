# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The camera of a live world: a child process renders, so that nobody waits for a picture."""

from __future__ import annotations

import multiprocessing
import signal
from contextlib import suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from typing import NamedTuple

from edgefusion.sim.world import World
from edgefusion.types import Pose2D

_QUALITY = 90
_SLACK_S = 2.0


class Picture(NamedTuple):
    """A frame, and when it was captured."""

    stamp_ns: int
    jpeg: bytes


class LiveCamera:
    """Renders one picture after the other. ready is False until its child can: a second or so, and for ever without
    Panda3D: fault says why then."""

    def __init__(self, world: World, seed: int) -> None:
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._child = context.Process(target=_render, args=(theirs, world, seed), daemon=True)
        resource_tracker.ensure_running()  # or start() does it, and lets SIGINT through again
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self._child.start()  # it inherits that: a terminal's Ctrl-C is the parent's, which ends its child
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        theirs.close()
        self.ready, self.fault = False, ""
        self._asked = False

    @property
    def pid(self) -> int | None:
        """The child's process id."""
        return self._child.pid

    def ask(self, stamp_ns: int, pose: Pose2D, turn_radps: float) -> bool:
        """Begins a picture from there; False while the last one is not done."""
        if not self.ready or self._asked:
            return False
        with suppress(OSError):
            self._ours.send((stamp_ns, pose, turn_radps))
            self._asked = True
        return self._asked

    def take(self) -> Picture | None:
        """The picture that is done, once; never waits."""
        try:
            while self._ours.poll():
                said = self._ours.recv()
                if isinstance(said, str):
                    self.ready, self.fault = not said, said
                    continue
                self._asked = False
                return Picture(*said)
        except (OSError, EOFError):
            self.ready, self.fault = False, self.fault or "the camera's process has ended"
        return None

    def close(self) -> None:
        """Ends the child."""
        self._ours.close()
        self._child.join(_SLACK_S)
        if self._child.is_alive():
            self._child.kill()
            self._child.join()


def _render(pipe: Connection, world: World, seed: int) -> None:
    """Says an empty text when it is ready, else what is missing; then a picture for every pose."""
    from edgefusion.errors import RefusedError
    from edgefusion.sim.camera_pictures import CameraPictures

    with suppress(EOFError, OSError):
        try:
            pictures = CameraPictures(world, seed)
        except RefusedError as error:
            pipe.send(str(error))
            return
        with pictures:
            pipe.send("")
            while True:
                stamp_ns, pose, turn_radps = pipe.recv()
                pipe.send((stamp_ns, pictures.jpeg(pose, turn_radps, _QUALITY)))
