# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Joining the bus whenever there is one, from a thread: who drives a robot does not wait for it."""

from __future__ import annotations

import logging
import threading
from typing import Callable, Optional

import zenoh

from edgefusion.bus.session import Closable, UnreachableError
from edgefusion.waiting import Wake

log = logging.getLogger(__name__)

OPENING_S, PAUSE_S = 1.0, 0.5
"""So long an attempt of a process may take, and so much later it may end; so long until the next one."""


class Joining:
    """open_session: raises UnreachableError where there is no router. joined: is called with the session, once, in the
    thread. What else they raise ends it, and is in `failure`, for who looks to raise.
    """

    def __init__(
        self,
        open_session: Callable[[], zenoh.Session],
        joined: Callable[[zenoh.Session], None],
        pause_s: float = PAUSE_S,
    ) -> None:
        self._open, self._joined, self._pause_s = open_session, joined, pause_s
        self._ending, self._wake = False, Wake()
        self._session: Optional[Closable] = None
        self.failure: Optional[Exception] = None
        self._thread = threading.Thread(target=self._run, name="joining the bus", daemon=True)

    def begin(self) -> None:
        """Returns at once."""
        self._thread.start()

    def end(self) -> None:
        """Leaves the bus, or the attempt, after as long as one attempt takes at most."""
        self._ending = True
        self._wake()
        self._thread.join()
        if self._session is not None:
            self._session.close()

    def _run(self) -> None:
        try:
            session = self._keep_trying()
            if session is not None:
                self._session = session
                self._joined(session)
        except Exception as error:
            self.failure = error

    def _keep_trying(self) -> Optional[zenoh.Session]:
        said = False
        while not self._ending:
            try:
                return self._open()
            except UnreachableError as error:
                if not said:
                    log.warning("bus: not there yet: %s", error)
                said = True
            self._wake.wait(self._pause_s)
        return None
