# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A small LMS2xx on a pty, written from the protocol's description alone: deaf and babbling at the wrong speed."""

from __future__ import annotations

import os
import select
import termios
import threading
import tty

from edgefusion.drivers.lms2xx_telegram import ACK, NAK, TO_LASER, TelegramReader, encode

SPEEDS = {0x40: 38400, 0x41: 19200, 0x42: 9600, 0x48: 500000}
TERMIOS = {9600: termios.B9600, 19200: termios.B19200, 38400: termios.B38400, 500000: termios.B500000}


class ScriptedLms2xx:
    """Answers on `port` from entering to leaving; what it is may be set before, what it became read after."""

    def __init__(self, baud: int = 9600, streaming: bytes = b"") -> None:
        self.baud = baud
        self.streaming = streaming  # the command's last byte, empty while it does not stream
        self.variant = (180, 100)
        self.block = bytearray(range(40, 72))
        self.block[5:7] = [0, 1]
        self.type_6 = 0x10
        self.naks = 0
        self.commands: list[bytes] = []
        self.refused: set[bytes] = set()
        self.say: list[bytes] = []  # telegrams of its own accord
        self._installation = False
        self._reader = TelegramReader(TO_LASER)

    def __enter__(self) -> ScriptedLms2xx:
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.port = os.ttyname(slave)
        self._slave, self._end = slave, threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()
        os.close(self._master)
        os.close(self._slave)

    def _run(self) -> None:
        while not self._end.is_set():
            readable, _, _ = select.select([self._master], [], [], 0.003)
            if readable:
                self._hear(os.read(self._master, 4096))
            for telegram in self.say:
                self._send(telegram)
            self.say = []
            if self.streaming:
                self._send(encode(self._scan(), 0x80))

    def _same_speed(self) -> bool:
        return termios.tcgetattr(self._slave)[4] == TERMIOS[self.baud]

    def _send(self, data: bytes) -> None:
        if select.select([], [self._master], [], 0)[1]:
            os.write(self._master, data if self._same_speed() else bytes(byte ^ 0x5A for byte in data))

    def _hear(self, data: bytes) -> None:
        if not self._same_speed():
            return
        for item in self._reader.feed(data):
            if item.handshake is None:
                self._obey(item.payload)

    def _obey(self, command: bytes) -> None:
        self.commands.append(command)
        if self.naks:
            self.naks -= 1
            return self._send(bytes([NAK]))
        reply = b"\x92" if command in self.refused else self._reply(command)
        self._send(bytes([ACK]) + encode(reply + bytes([self.type_6]), 0x80))
        if command[0] == 0x20 and command[1] in SPEEDS:
            self.baud = SPEEDS[command[1]]
        return None

    def _reply(self, command: bytes) -> bytes:
        kind = command[0]
        if kind == 0x31:
            return self._status()
        if kind == 0x3A:
            return b"\xbaLMS200;30106;V02.10 "
        if kind == 0x74:
            return b"\xf4" + bytes(self.block)
        if kind == 0x77:
            if not self._installation or len(command) - 1 != len(self.block):
                return b"\xf7\x00"
            self.block[:] = command[1:]
            return b"\xf7\x01" + command[1:]
        if kind == 0x3B:
            self.variant, self.streaming = (command[1], command[3]), b""
            return b"\xbb\x01" + command[1:]
        if command[1] == 0x00:
            self._installation = command[2:] == b"SICK_LMS"
            return b"\xa0" + bytes([not self._installation])
        if command[1] in (0x24, 0x25, 0x2A):
            self.streaming = b"" if command[1] == 0x25 else command[1:]
        return b"\xa0\x00"

    def _status(self) -> bytes:
        status = bytearray(153)
        status[0], status[102], status[122] = 0xB1, self.block[5], self.block[6]
        status[107:111] = bytes([self.variant[0], 0, self.variant[1], 0])
        return bytes(status)

    def _scan(self) -> bytes:
        angle, resolution = self.variant
        partial = self.streaming == b"\x2a"
        count = angle + 1 if partial else angle * 100 // resolution + 1
        header = count | self.block[6] << 14 | (0x2000 if partial else 0)
        return b"\xb0" + header.to_bytes(2, "little") + (2000).to_bytes(2, "little") * count + bytes([self.type_6])
