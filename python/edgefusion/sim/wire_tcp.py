# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A simulated device behind a TCP port, as an adapter from serial to Ethernet serves it: one client at a time."""

from __future__ import annotations

import socket
from contextlib import suppress

from edgefusion.errors import RefusedError

_READ_BYTES = 4096


class TcpWire:
    """host, port: where it listens; port 0: any that is free. name: what a client of ours opens.

    Raises RefusedError where the port is taken.
    """

    baudrate = None

    def __init__(self, port: int = 8101, host: str = "127.0.0.1") -> None:
        try:
            self._listener = socket.create_server((host, port), backlog=1)
        except OSError as error:
            raise RefusedError(f"port {port}: expected one that is free, got {error.strerror}") from error
        self._listener.setblocking(False)
        self.port = self._listener.getsockname()[1]
        self.name = f"socket://{host}:{self.port}"
        self._client: socket.socket | None = None

    def read(self) -> bytes:
        """What the client wrote; never waits. The next client is served when the one before it has left."""
        if self._client is None:
            self._accept()
        if self._client is None:
            return b""
        try:
            data = self._client.recv(_READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._leave()
        return data

    def write(self, data: bytes) -> None:
        """What nobody takes is lost."""
        if self._client is None:
            return
        try:
            self._client.send(data)
        except BlockingIOError:
            pass
        except OSError:
            self._leave()

    def close(self) -> None:
        """Nobody can connect any more."""
        self._leave()
        self._listener.close()

    def _accept(self) -> None:
        with suppress(BlockingIOError):
            self._client, _ = self._listener.accept()
            self._client.setblocking(False)
            self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def _leave(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
