# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The base's answers to what it is asked over the bus."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Tuple, Type

import msgspec
import zenoh

from edgefusion.bus.freshness import Freshness, limits_of
from edgefusion.bus.queries import Service
from edgefusion.bus.requests import GotoRequest, InspectRequest, ResumeRequest, StopRequest
from edgefusion.bus.topics import GOTO, INSPECT, RESUME, STOP, key_of
from edgefusion.clock import Clock, system_clock
from edgefusion.config import BusConfig
from edgefusion.service.base import Base
from edgefusion.service.helm import Helm


class BaseServices:
    """What the helm is asked for is done in the base's loop; each key has a thread that waits for it.

    before: takes what came on the topics, in the loop's thread: it came before what is asked for then, a velocity
    before the `resume` that ends it, a heartbeat before the one that needs it.
    """

    def __init__(
        self,
        session: zenoh.Session,
        config: BusConfig,
        base: Base,
        helm: Helm,
        before: Callable[[], None],
        clock: Clock = system_clock,
    ) -> None:
        def ask(call: Callable[[], None], late_too: bool = False) -> None:
            def do() -> None:
                before()
                call()

            base.ask(do, late_too)

        def goto(request: GotoRequest) -> None:
            ask(lambda: helm.goto(request))

        def stop(request: StopRequest) -> None:
            ask(lambda: helm.stop(request), late_too=True)  # of a loop that is late, it stops what goes on then

        def resume(_: ResumeRequest) -> None:
            ask(lambda: helm.resume(clock()))

        def inspect(request: InspectRequest) -> None:
            ask(lambda: helm.inspect(request))

        served: List[Tuple[str, Type[msgspec.Struct], Callable[[Any], None]]] = [
            (GOTO, GotoRequest, goto),
            (STOP, StopRequest, stop),
            (RESUME, ResumeRequest, resume),
            (INSPECT, InspectRequest, inspect),
        ]
        limits = limits_of(config)
        self._services = {
            name: Service(session, key_of(config.robot, name), kind, handle, Freshness(limits), clock)
            for name, kind, handle in served
        }

    def refused(self) -> Dict[str, str]:
        """How many requests did not count, by why, where there were any."""
        return {
            f"{name} refused, {why.value}": str(count)
            for name, service in self._services.items()
            for why, count in dict(service.freshness.counts).items()
        }
