# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The base on the bus, from when there is one: who drives a robot waits neither for it nor for who listens."""

from __future__ import annotations

from typing import Dict, Mapping, NamedTuple, Sequence, Union

import zenoh

from edgefusion.bus.clock_id import clock_id
from edgefusion.bus.clock_reading import ClockTeller
from edgefusion.bus.joining import OPENING_S, Joining
from edgefusion.bus.liveliness import declare_alive
from edgefusion.bus.session import open_member
from edgefusion.clock import system_clock
from edgefusion.config import BusConfig
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.transform import FrameTransform
from edgefusion.service.base import Base
from edgefusion.service.base_inbox import BaseInbox, FromVision
from edgefusion.service.base_inputs import Outputs
from edgefusion.service.base_outlet import BaseOutlet, Figures
from edgefusion.service.base_reports import COMPONENT
from edgefusion.service.base_services import BaseServices
from edgefusion.service.helm import Helm
from edgefusion.service.teller import Teller
from edgefusion.types import Scan

TELLING_S = 0.5
"""So long the last that was done may take to be told."""


class _Joined(NamedTuple):
    """All that is on the bus; the token is alive while it is kept."""

    inbox: BaseInbox
    outlet: BaseOutlet
    services: BaseServices
    clock: ClockTeller
    token: zenoh.LivelinessToken


class BaseBus:
    """take() is for the loop's thread. tell: what that did, and every scan, from any thread.

    figures: what there is to say of the base beside what it did.
    """

    def __init__(
        self,
        config: BusConfig,
        mounting: Sequence[FrameTransform],
        stamper: Stamper,
        helm: Helm,
        base: Base,
        figures: Figures,
    ) -> None:
        self._config, self._mounting, self._stamper = config, mounting, stamper
        self._helm, self._base, self._base_figures = helm, base, figures
        self._clock_id = clock_id()
        self._joined: _Joined | None = None
        self._joining = Joining(lambda: open_member(config, OPENING_S), self._join)
        self.tell: Teller[Union[Outputs, Scan]] = Teller("publishing", self._publish)

    def begin(self) -> None:
        """Returns at once."""
        self.tell.begin()
        self._joining.begin()

    def end(self) -> None:
        """Leaves the bus."""
        self.tell.end(TELLING_S)
        self._joining.end()

    def take(self, now_ns: int) -> FromVision:
        """Hands the helm what people want, and gives what vision says. Never waits.

        Raises what has kept it from joining the bus for good: a robot that nobody can stop does not set off.
        """
        if self._joining.failure is not None:
            raise self._joining.failure
        joined = self._joined
        if joined is None:
            return FromVision()
        joined.inbox.command(self._helm, now_ns)
        return joined.inbox.from_vision()

    def _join(self, session: zenoh.Session) -> None:
        config = self._config
        inbox = BaseInbox(session, config, self._clock_id)
        outlet = BaseOutlet(session, config, self._mounting, self._clock_id, self._stamper, self._figures)
        services = BaseServices(
            session, config, self._base, self._helm, lambda: inbox.command(self._helm, system_clock())
        )
        clock = ClockTeller(session, config.robot, self._clock_id)
        self._joined = _Joined(inbox, outlet, services, clock, declare_alive(session, config.robot, COMPONENT))

    def _publish(self, what: Union[Outputs, Scan]) -> None:
        if self._joined is None:
            return
        if isinstance(what, Scan):
            self._joined.outlet.tell_scan(what)
        else:
            self._joined.outlet.tell(what)

    def _figures(self) -> Mapping[str, str]:
        figures: Dict[str, str] = dict(self._base_figures())
        if self._joined is not None:
            figures.update(self._joined.inbox.refused())
            figures.update(self._joined.services.refused())
        if self.tell.lost:
            figures["published too late, lost"] = str(self.tell.lost)
        return figures
