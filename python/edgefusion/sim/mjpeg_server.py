# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Pictures as they come, as MJPEG over HTTP, from threads: for whoever reads a camera's URL, or looks at the page."""

from __future__ import annotations

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType

from edgefusion.errors import RefusedError

HOST = "127.0.0.1"
STAMP_HEADER = "X-Timestamp-Ns"
"""Of a picture in the stream: when it was captured."""

_BOUNDARY = "frame"
_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>edgefusion</title>
<style>body{margin:0;background:#1c1e22}img{display:block;margin:auto;max-width:100%;max-height:100vh}</style>
<img src="stream" alt="what the camera sees">
"""


class MjpegServer:
    """Serves the newest picture to everyone who looks, until it is closed. Raises RefusedError for a taken port."""

    def __init__(self, port: int = 0) -> None:
        self._newest = _Newest()
        try:
            self._server = _Server((HOST, port), self._newest)
        except (OSError, OverflowError) as error:
            raise RefusedError(f"port {port}: cannot be served: {error}") from error
        self.url = f"http://{HOST}:{self._server.server_address[1]}/"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    def __enter__(self) -> MjpegServer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Ends the streams and gives the port back."""
        self._newest.end()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    @property
    def watched(self) -> threading.Event:
        """Set when somebody looks, or ever has."""
        return self._newest.watched

    def put(self, jpeg: bytes, stamp_ns: int | None = None) -> None:
        """The newest picture from now on; who is slow misses those before it."""
        stamp = "" if stamp_ns is None else f"{STAMP_HEADER}: {stamp_ns}\r\n"
        self._newest.set(stamp, jpeg)


class _Newest:
    """The newest picture as a JPEG and a header line for its stamp, which threads wait for. watched: whether one ever
    has."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._picture, self._number, self._ended = ("", b""), 0, False
        self.watched = threading.Event()

    def set(self, stamp: str, jpeg: bytes) -> None:
        with self._changed:
            self._picture, self._number = (stamp, jpeg), self._number + 1
            self._changed.notify_all()

    def end(self) -> None:
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def after(self, number: int) -> tuple[int, str, bytes] | None:
        """The first picture with a higher number, as soon as there is one; None when there will be none."""
        with self._changed:
            self._changed.wait_for(lambda: self._ended or self._number > number)
            return None if self._ended else (self._number, *self._picture)


class _Server(ThreadingHTTPServer):
    daemon_threads = True  # a browser that stopped reading holds nothing up

    def __init__(self, address: tuple[str, int], newest: _Newest) -> None:
        self.newest = newest
        super().__init__(address, _Handler)


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        answer = {"/": self._page, "/stream": self._stream}.get(self.path)
        if answer is None:
            self.send_error(404)
            return
        try:
            answer()
        except OSError:  # the browser has gone
            self.close_connection = True

    def log_message(self, format: str, *args: object) -> None:
        """Silent: the terminal shows the progress."""

    def _page(self) -> None:
        body = _PAGE.encode()
        self._begin("text/html; charset=utf-8", len(body))
        self.wfile.write(body)

    def _stream(self) -> None:
        self._begin(f"multipart/x-mixed-replace; boundary={_BOUNDARY}", None)
        self.server.newest.watched.set()
        self.wfile.write(f"--{_BOUNDARY}\r\n".encode())
        newest = self.server.newest.after(0)
        while newest is not None:
            number, stamp, jpeg = newest
            head = f"Content-Type: image/jpeg\r\n{stamp}Content-Length: {len(jpeg)}\r\n\r\n"
            # The boundary at once: browsers show a picture when they have seen its end.
            self.wfile.write(head.encode() + jpeg + f"\r\n--{_BOUNDARY}\r\n".encode())
            newest = self.server.newest.after(number)

    def _begin(self, content: str, length: int | None) -> None:
        self.send_response(200)
        self.send_header("Content-Type", content)
        self.send_header("Cache-Control", "no-store")
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.end_headers()
