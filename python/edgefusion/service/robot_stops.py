# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Last stops under way, each in a thread of its own: the supervisor's loop never waits for a port."""

from __future__ import annotations

import logging
import threading
from collections import deque
from typing import Any, Callable, Deque, Mapping, Sequence, Tuple

from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.errors import RefusedError
from edgefusion.service.last_stop import RobotLine, robot_line, stop_robot

_LOG = logging.getLogger(__name__)

Stopper = Callable[[RobotLine, "int | None"], int]
"""As last_stop.stop_robot."""


class RobotStops:
    """wake: called, in a thread, when one is over."""

    def __init__(self, wake: Callable[[], None], stop: Stopper = stop_robot) -> None:
        self._wake, self._stop = wake, stop
        self._over: Deque[Tuple[str, bool]] = deque()

    def begin(self, name: str, status: Mapping[str, Any], by_ns: int | None) -> None:
        """For a child that is gone. status: the last in which it named its robot's port."""
        # No thread that hangs in a driver shall hold up the end of the program.
        threading.Thread(target=self._run, args=(name, status, by_ns), name=f"stop {name}", daemon=True).start()

    def take(self) -> Sequence[Tuple[str, bool]]:
        """Those that are over since the last time: which child's, and whether its robot is known to have heard it, or
        is nobody's business here."""
        over = []
        while self._over:
            over.append(self._over.popleft())
        return over

    def _run(self, name: str, status: Mapping[str, Any], by_ns: int | None) -> None:
        stopped = False
        try:
            stopped = self._try(name, status, by_ns)
        except PortBusyError as error:
            _LOG.warning("%s: its robot is left to who has it: %s", name, error)
            stopped = True
        except (RuntimeError, RefusedError) as error:
            _LOG.error("%s: its robot may still move: %s", name, error)
        except Exception:
            _LOG.exception("%s: its robot may still move: an error that should not be", name)
        finally:
            self._over.append((name, stopped))
            self._wake()

    def _try(self, name: str, status: Mapping[str, Any], by_ns: int | None) -> bool:
        line = robot_line(status)
        if line is None:
            _LOG.info("%s: it never named a robot: nothing to stop", name)
            return True
        baudrate = self._stop(line, by_ns)
        _LOG.warning("%s: its robot was told to stop, on %s at %d baud", name, line.port, baudrate)
        return True
