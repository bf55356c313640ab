# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A thread that owns one device: it starts it, polls it all the time, and starts it anew when it was lost."""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import replace
from typing import Callable, Generic, Protocol, Sequence, TypeVar

from edgefusion.clock import Clock, system_clock
from edgefusion.drivers.backoff import Backoff
from edgefusion.drivers.link import LinkError
from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.errors import RefusedError
from edgefusion.service.device_news import DeviceNews
from edgefusion.service.ending import EndedError, Ending
from edgefusion.types import Health, HealthState
from edgefusion.waiting import join

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)

LONGEST_PAUSE_NS = 250_000_000
"""Before a device is started again. To look for a port costs nothing, and one that does not answer takes its time."""

_IDLE_S = 0.01
_LOG = logging.getLogger(__name__)


class Device(Protocol[T_co]):
    """What a thread can own. Nothing but start() takes longer than some 20 ms, and that ends when it is asked to.

    start, poll: raise LinkError where the device is lost or does not answer, RefusedError where it will not do what it
    is configured to. close: leaves the device at rest, from any state.
    """

    @property
    def health(self) -> Health: ...

    def start(self) -> None: ...

    def poll(self) -> Sequence[T_co]: ...

    def close(self) -> None: ...


def nothing() -> None:
    """Is prepared."""


class DeviceThread(Generic[T]):
    """busy: why the device cannot be had, where another instance holds its port.

    wake: called, in this thread, when the health's state changes, so that nobody waits for a cycle to see it. prepare:
    called first of all, in this thread.

    An error that no driver should raise closes the device for good; the reason is its health.
    """

    def __init__(
        self,
        device: Device[T],
        ending: Ending,
        wake: Callable[[], None],
        clock: Clock = system_clock,
        pause: Callable[[float], None] = time.sleep,
        prepare: Callable[[], object] = nothing,
    ) -> None:
        self._device, self._ending, self._wake, self._prepare = device, ending, wake, prepare
        self._clock, self._pause = clock, pause
        self._name = device.health.component
        self._backoff = Backoff(longest_ns=LONGEST_PAUSE_NS)
        self._started = False
        self.busy: PortBusyError | None = None
        self._news: DeviceNews[T] = DeviceNews(device.health)
        self._thread = threading.Thread(target=self.run, name=self._name, daemon=True)

    @property
    def news(self) -> DeviceNews[T]:
        """As of now, for any thread."""
        return self._news

    @property
    def is_alive(self) -> bool:
        return self._thread.is_alive()

    def begin(self) -> None:
        """Starts the thread."""
        self._thread.start()

    def end(self) -> None:
        """Asks it to end; it begins to close the device within 20 ms, whatever it was doing."""
        self._ending.ask()

    def join(self, timeout_s: float) -> bool:
        """Whether it has ended by then."""
        return join(self._thread, timeout_s)

    def run(self) -> None:
        """All that the thread does, until it is asked to end or what should not happen does."""
        try:
            self._prepare()
            while not self._ending.asked:
                self.turn()
        except EndedError:
            pass
        except Exception as error:  # whatever it is: it must not go unseen, and the device must not be left as it is
            self._broke(error)
        finally:
            self._close()

    def turn(self) -> None:
        """One start, one poll, or a moment's rest."""
        try:
            if self._started:
                self._take(self._device.poll())
            elif self._backoff.due(self._clock()):
                self._device.start()
                self._started = True
                self._tell(replace(self._news, health=self._device.health))
            else:
                self._pause(_IDLE_S)
        except PortBusyError as error:
            self.busy = error
            self._lost(str(error))
        except (LinkError, RefusedError) as error:
            self._lost(str(error))

    def _take(self, items: Sequence[T]) -> None:
        news = replace(self._news, health=self._device.health)
        if items:
            self._backoff.reset()
            news = replace(news, newest=items[-1], received_ns=self._clock())
        self._tell(news)

    def _lost(self, reason: str) -> None:
        """Until it is started again there is no newest."""
        self._started = False
        self._backoff.failed(self._clock())
        self._tell(replace(self._news, health=self._failed(reason), newest=None, received_ns=None))

    def _broke(self, error: Exception) -> None:
        _LOG.exception("%s: closed after an error that no driver should raise", self._name)
        self._lost(f"closed after {type(error).__name__}: {error}")

    def _failed(self, reason: str) -> Health:
        return Health(self._name, HealthState.FAILED, reason)

    def _close(self) -> None:
        """Once more where that fails: what it says last, as to stop, may not have been said yet."""
        self._ending.close()
        for _ in range(2):
            try:
                self._device.close()
            except Exception as error:
                self._broke(error)
            else:
                return

    def _tell(self, news: DeviceNews[T]) -> None:
        before = self._news.health
        if news.health.state is HealthState.FAILED and before.state is not HealthState.FAILED:
            _LOG.warning("%s: %s", self._name, news.health.reason)
            news = replace(news, failures=news.failures + 1, failure=news.health.reason)
        self._news = news
        if news.health.state is not before.state:
            self._wake()
