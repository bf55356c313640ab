# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The process of the bus: the router, and nothing else that could be hurt by what comes from the network."""

from __future__ import annotations

import resource
import time
from contextlib import suppress
from typing import Callable

from edgefusion.bus.liveliness import declare_alive
from edgefusion.bus.router import open_router
from edgefusion.bus.session import Closable
from edgefusion.config import BusConfig
from edgefusion.service.heartbeat import Heartbeat

COMPONENT = "bus"
TURN_S = 0.1


def run_bus(config: BusConfig, beats: Heartbeat, pause: Callable[[float], None] = time.sleep) -> None:
    """Routes until an exception, as a signal raises it, or the supervisor is gone.

    Raises RefusedError for keys that will not do, OSError for an endpoint that cannot be listened on.
    """
    _take_all_handles()
    router = open_router(config)
    closable: Closable = router
    token = declare_alive(router, config.robot, COMPONENT)
    status = {"says": f"listens on {', '.join(config.listen)}"}
    try:
        while not beats.parent_gone():
            beats.beat(status)
            pause(TURN_S)
    finally:
        del token
        closable.close()


def _take_all_handles() -> None:
    """Who connects and then says nothing holds one for some twenty seconds, also without keys: with the usual thousand
    of them nobody else would get in."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
