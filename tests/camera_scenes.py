# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures for the tests of the camera, a source that follows a script, and an MJPEG server that fails on demand."""

from __future__ import annotations

import socket
import threading
import time
from typing import Callable, Iterable, Iterator

import cv2
import numpy as np

from edgefusion.drivers.camera_pipe import PipeEndedError
from edgefusion.drivers.camera_source import Picture

WIDTH, HEIGHT = 160, 120


def scene(seed: int, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """A picture of coloured tiles, another for each seed."""
    tiles = np.random.default_rng(seed).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    return cv2.resize(tiles, (width, height), interpolation=cv2.INTER_NEAREST)


def flat(level: int) -> np.ndarray:
    return np.full((HEIGHT, WIDTH, 3), level, np.uint8)


def wait_until(condition: Callable[[], bool], limit_s: float = 30.0) -> None:
    """Returns as soon as it is so; the limit is only for what never comes."""
    end = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.005)


class ScriptedSource:
    """Gives what the script says: a picture, None for nothing in time, or a text: the end, with that reason."""

    def __init__(self, script: Iterable[Picture | str | None]) -> None:
        self._script: Iterator[Picture | str | None] = iter(script)
        self.closed = 0

    def read(self, timeout_s: float) -> Picture | None:
        item = next(self._script, None)
        if isinstance(item, str):
            raise PipeEndedError(item)
        return item

    def close(self) -> None:
        self.closed += 1


class MjpegServer:
    """A camera on the network. behaviour: "stream", "freeze", "hang" or "close", and it may change at any time."""

    def __init__(self) -> None:
        self.behaviour, self.connections = "stream", 0
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}/stream.mjpg"
        self._stopped = threading.Event()
        self._threads = [threading.Thread(target=self._listen)]
        self._threads[0].start()

    def _listen(self) -> None:
        while True:
            connection, _ = self._listener.accept()
            if self._stopped.is_set():
                connection.close()
                return
            self.connections += 1
            thread = threading.Thread(target=self._serve, args=(connection,))
            self._threads.append(thread)
            thread.start()

    def _serve(self, connection: socket.socket) -> None:
        with connection:
            try:
                connection.recv(4096)
                connection.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n")
                number = 0
                while self.behaviour != "close" and not self._stopped.wait(0.02):
                    number += self.behaviour == "stream"
                    if self.behaviour != "hang":
                        self._send(connection, scene(number))
            except OSError:
                pass  # the reader has gone

    @staticmethod
    def _send(connection: socket.socket, image: np.ndarray) -> None:
        jpeg = cv2.imencode(".jpg", image)[1].tobytes()
        head = f"--b\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n".encode()
        connection.sendall(head + jpeg + b"\r\n")

    def stop(self) -> None:
        self._stopped.set()
        socket.create_connection(self._listener.getsockname()).close()
        for thread in self._threads:
            thread.join()
        self._listener.close()
