# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The driver of a SICK LMS2xx: stamped scans from a port, and how the scanner is."""

from __future__ import annotations

import math
import time
from contextlib import suppress
from typing import Callable

from edgefusion.clock import Clock, system_clock
from edgefusion.config.laser import LaserConfig
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.lms2xx_judgement import Judgement
from edgefusion.drivers.lms2xx_line import LaserError, LaserLine
from edgefusion.drivers.lms2xx_messages import POWER_ON, STOP, LaserStatus
from edgefusion.drivers.lms2xx_scan import SCAN, parse_scan, range_mask
from edgefusion.drivers.lms2xx_setup import difference, read_model, set_speed, set_up, start_stream
from edgefusion.drivers.lms2xx_status import COMPONENT, health_of
from edgefusion.drivers.lms2xx_telegram import FRAME_BYTES, MAX_TELEGRAM_BYTES, Received
from edgefusion.drivers.lms2xx_timing import (
    backlog_ns,
    first_byte_ns,
    mean_wait_ns,
    scan_age_limit_s,
    silence_limit_s,
    stamped,
)
from edgefusion.errors import RefusedError
from edgefusion.types import Health, HealthState, Scan

ANSWER_S = 0.3
POWER_ON_BAUD = 9600
GIVEN_UP_S = 5.0
"""After so long without a scan from a line that speaks, nothing but a new start can help."""


class Lms2xx:
    """One scanner on a link. answer_s: how long it may take for an answer, beside what the line takes.

    Not for several threads. After a LinkError start() begins anew, from any state of the scanner.
    """

    def __init__(
        self,
        link: Link,
        config: LaserConfig,
        clock: Clock = system_clock,
        pause: Callable[[float], None] = time.sleep,
        answer_s: float = ANSWER_S,
    ) -> None:
        self._link = link
        self._config = config
        self._answer_s = answer_s
        self._line = LaserLine(link, clock, pause)
        self._status: LaserStatus | None = None
        self._model = ""
        self._judgement = Judgement()
        self._clock = clock
        self._silence_limit_s, self._scan_ns = math.inf, 0
        self._health = Health(COMPONENT, HealthState.STARTING, "not started")

    @property
    def health(self) -> Health:
        """As of the last scan or failure."""
        return self._health

    @property
    def status(self) -> LaserStatus | None:
        """What the scanner said of itself at the start; None before."""
        return self._status

    @property
    def model(self) -> str:
        """What the scanner calls itself; empty before the start, and where it does not say."""
        return self._model

    @property
    def scan_age_limit_s(self) -> float | None:
        """So old the newest scan may get while all is well; None before the start."""
        return None if self._status is None else scan_age_limit_s(*self._pace(self._status))

    def start(self) -> None:
        """From any state to streaming. Raises LinkError, RefusedError for what the scanner does not take."""
        try:
            self._link.open()
            self._link.expect_within(math.inf)  # an answer has its own deadline
            status = set_up(self._line, self._config, self._answer_s)
            range_mask(status.measuring_mode)
            self._model = read_model(self._line, self._answer_s)
            start_stream(self._line, self._config, self._answer_s)
            self._judgement = Judgement(self._line.reader.discarded_bytes)
            self._silence_limit_s, self._scan_ns = silence_limit_s(*self._pace(status)), self._clock()
            self._link.expect_within(self._silence_limit_s)
        except (LinkError, RefusedError) as error:
            raise self._failed(error) from None
        self._status = status
        self._health = self._health_with(status.status)

    def read(self, moving: bool = False) -> list[Scan]:
        """The scans that came within 20 ms, in the laser's frame; what is no scan of this scanner is not among them,
        nor one that is not to be driven by: the health says why. moving: whether the robot's wheels turn.

        Raises LinkError where the line is lost, speaks without a scan for GIVEN_UP_S, or the scanner started anew, as
        after a dip of its power.
        """
        if self._status is None:
            raise LaserError(f"{self._link.name}: expected start() before read()")
        try:
            found, now_ns = self._line.receive()
            scans = [scan for item in found for scan in self._scans(item, self._status, now_ns, moving)]
            self._check_pause(now_ns)
            return scans
        except LinkError as error:
            raise self._failed(error) from None

    def close(self) -> None:
        """Stops the stream, leaves the scanner at the speed it has after power-on, and closes. Raises nothing."""
        if self._link.is_open:
            with suppress(LinkError, RefusedError):
                self._line.ask(STOP, self._answer_s)
                set_speed(self._line, POWER_ON_BAUD, self._answer_s)
        self._link.close()
        self._status = None
        self._health = Health(COMPONENT, HealthState.STARTING, "not started")

    def _scans(self, item: Received, status: LaserStatus, now_ns: int, moving: bool) -> list[Scan]:
        if item.handshake is not None:
            return []
        if item.payload[0] == POWER_ON:
            raise LaserError(f"{self._link.name}: the scanner started anew: {item.payload[1:-1].decode('latin-1')}")
        if item.payload[0] != SCAN:
            return []
        try:
            raw = parse_scan(item.payload)
        except RefusedError as error:
            self._health = Health(COMPONENT, HealthState.DEGRADED, str(error))
            return []
        self._scan_ns = now_ns
        size = len(item.payload) + FRAME_BYTES
        scan = stamped(raw, status.measuring_mode, self._measured_ns(item.begin, size, raw.variant.turns, now_ns))
        self._judgement.line.telegram(size, self._line.reader.discarded_bytes)
        fault = self._judgement.fault(raw.values.tobytes(), scan.ranges_m, now_ns, moving)
        self._health = Health(COMPONENT, HealthState.FAILED, fault) if fault else self._health_with(raw.status)
        return [] if fault else [scan]

    def _measured_ns(self, begin: int, size: int, turns: int, now_ns: int) -> int:
        """When the last beam of a scan was measured, whose telegram of so many bytes begins there."""
        baudrate = self._link.baudrate
        came_ns = now_ns - backlog_ns(self._link.waiting_bytes, size, turns, baudrate)
        first_ns = first_byte_ns(came_ns, begin, self._line.reader.received_bytes, baudrate)
        return first_ns - mean_wait_ns(size, turns, baudrate)

    def _check_pause(self, now_ns: int) -> None:
        """A line of noise is not silent; where a whole telegram waits, it is the reader that was."""
        pause_s = (now_ns - self._scan_ns) / 1e9
        if pause_s <= self._silence_limit_s or self._link.waiting_bytes > MAX_TELEGRAM_BYTES:
            return
        missed = f"no scan for {pause_s:.2f} s"
        if pause_s > GIVEN_UP_S:
            raise LaserError(f"{self._link.name}: {missed}")
        self._health = Health(COMPONENT, HealthState.FAILED, missed)

    def _pace(self, status: LaserStatus) -> tuple[int, int, int]:
        """Beams and mirror turns of what it sends, and the speed of its line."""
        angle, turns = status.variant.angle, status.variant.turns
        partial = self._config.partial_scans
        return angle * (1 if partial else turns) + 1, 1 if partial else turns, self._link.baudrate

    def _health_with(self, status: int) -> Health:
        health = health_of(status)
        differs = difference(self._status, self._config) if self._status else ""
        if health.state is not HealthState.OK or not differs:
            return health
        return Health(COMPONENT, HealthState.DEGRADED, f"{differs}; write_eeprom would change it")

    def _failed(self, error: Exception) -> Exception:
        self._status = None
        self._health = Health(COMPONENT, HealthState.FAILED, str(error))
        return error
