# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A file that grows by whole pieces and leaves the disk some room."""

from __future__ import annotations

import errno
import fcntl
import os
from pathlib import Path
from typing import Callable, Union

ENDING_BYTES = 1 << 20
"""Kept free beside the reserve for a recording's summary, with ENDING_SHARE of what was written."""

ENDING_SHARE = 1 / 32

_BLOCK_BYTES = 512
"""In which the system tells what a file takes on the disk."""

Write = Callable[[int, Union[bytes, memoryview]], int]


def free_bytes(descriptor: int) -> int:
    """What may still be written on the disk that an open file is on."""
    disk = os.fstatvfs(descriptor)
    return disk.f_bavail * disk.f_frsize


class RecordFile:
    """A file at whose end whole pieces are written: of one that the disk does not take, nothing stays.

    Nobody else writes there meanwhile: OSError (EBUSY) where somebody does already.
    reserve_bytes: what must be free on the disk after a write, or the write raises OSError (ENOSPC), as does what the
    system refuses. write, free_bytes: of the system.
    """

    def __init__(
        self,
        descriptor: int,
        reserve_bytes: int = 0,
        write: Write = os.write,
        free_bytes: Callable[[int], int] = free_bytes,
    ) -> None:
        self._descriptor, self._write, self._free_bytes = descriptor, write, free_bytes
        self._reserve_bytes = reserve_bytes
        _lock(descriptor)
        self._end = os.lseek(descriptor, 0, os.SEEK_END)

    @classmethod
    def create(
        cls,
        path: Path,
        reserve_bytes: int = 0,
        overwrite: bool = False,
        free_bytes: Callable[[int], int] = free_bytes,
    ) -> RecordFile:
        """A new file. Raises OSError, FileExistsError where it is there already and not to be replaced; what is there
        stays as it is then, and is dropped only once it is sure that there is room for more."""
        try:
            file, is_new = cls.open(path, os.O_CREAT | os.O_EXCL, reserve_bytes, free_bytes), True
        except FileExistsError:
            if not overwrite:
                raise
            file, is_new = cls.open(path, 0, reserve_bytes, free_bytes), False
        try:
            file._begin_anew()
            if is_new:
                _sync_folder(path.parent)
        except BaseException:
            file.close()
            if is_new:
                path.unlink()
            raise
        return file

    @classmethod
    def open(
        cls, path: Path, flags: int = 0, reserve_bytes: int = 0, free_bytes: Callable[[int], int] = free_bytes
    ) -> RecordFile:
        """A file that is there, to go on at its end. flags: of os.open, more than those. Raises OSError."""
        descriptor = os.open(path, os.O_RDWR | os.O_CLOEXEC | flags, 0o644)
        try:
            return cls(descriptor, reserve_bytes, free_bytes=free_bytes)
        except BaseException:
            os.close(descriptor)
            raise

    def write(self, data: bytes) -> int:
        """Appends all of the data, or raises OSError and the file is as before."""
        self._check_reserve(len(data), self._end)
        try:
            self._write_all(memoryview(data))
        except BaseException:
            self.cut(self._end)
            raise
        self._end += len(data)
        return len(data)

    def cut(self, end: int) -> None:
        """Drops everything from a byte on."""
        os.ftruncate(self._descriptor, end)
        self._end = os.lseek(self._descriptor, end, os.SEEK_SET)

    def tell(self) -> int:
        """Bytes written so far."""
        return self._end

    def sync(self) -> None:
        """Returns once everything is on the disk itself."""
        os.fsync(self._descriptor)

    def give_up_reserve(self) -> None:
        """From now on writes until the disk is full: for the ending, for which room was kept."""
        self._reserve_bytes = 0

    def close(self) -> None:
        """Closes the file."""
        os.close(self._descriptor)

    def _begin_anew(self) -> None:
        """Drops what is there, or raises OSError and it stays."""
        dropped_bytes = os.fstat(self._descriptor).st_blocks * _BLOCK_BYTES
        self._check_reserve(0, 0, dropped_bytes)
        self.cut(0)

    def _check_reserve(self, length: int, end: int, dropped_bytes: int = 0) -> None:
        if not self._reserve_bytes:
            return
        wanted = self._reserve_bytes + ENDING_BYTES + round(end * ENDING_SHARE)
        free = self._free_bytes(self._descriptor) + dropped_bytes
        if free - length < wanted:
            kept_mb = self._reserve_bytes / 1e6
            raise OSError(errno.ENOSPC, f"{free / 1e6:.0f} MB are free on the disk, {kept_mb:.0f} MB are to stay free")

    def _write_all(self, data: memoryview) -> None:
        while data:
            data = data[self._write(self._descriptor, data) :]


def _lock(descriptor: int) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OSError(errno.EBUSY, "somebody else is recording there") from None


def _sync_folder(folder: Path) -> None:
    """The name of a new file is on the disk, too."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
