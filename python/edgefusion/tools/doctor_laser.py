# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the laser answers, is set as configured, and sees. Its memory is not written."""

from __future__ import annotations

import time
from typing import Callable, Iterator, List

import msgspec
import numpy as np

from edgefusion.clock import Clock, system_clock
from edgefusion.drivers.link import Link, LinkError
from edgefusion.drivers.lms2xx import POWER_ON_BAUD, Lms2xx
from edgefusion.drivers.lms2xx_setup import difference
from edgefusion.drivers.port_lock import PortBusyError
from edgefusion.errors import RefusedError
from edgefusion.tools.doctor_finding import END_IT, HOLDER, Examination, Finding, State
from edgefusion.types import HealthState, Scan

_LISTENS_S = 2.0
_SILENT = (
    "look at its 24 V (a green lamp, a minute after power-on); the cable (crossed; 500000 baud only over RS-422); "
    "whether [robot] port and [laser] port are swapped: docs/wiring.md"
)
_LOOK = "look at its window, its cable and what is before it"
_SET = "set [laser] as the scanner is, or write_eeprom = true once, where it may change its memory"


def check_laser(
    exam: Examination, clock: Clock = system_clock, pause: Callable[[float], None] = time.sleep
) -> Iterator[Finding]:
    """Listens to it for two seconds."""
    if not exam.runs("base"):
        yield Finding("laser", State.SKIPPED, "base runs on another machine")
    elif exam.config.laser.port in exam.unusable:
        yield Finding("laser", State.SKIPPED, "its port cannot be used")
    else:
        yield _examined(exam, clock, pause)


def _examined(exam: Examination, clock: Clock, pause: Callable[[float], None]) -> Finding:
    settings = msgspec.structs.replace(exam.config.laser, write_eeprom=False)
    link = Link(settings.port, POWER_ON_BAUD, HOLDER, clock=clock, lock_folder=exam.lock_folder)
    laser = Lms2xx(link, settings, clock, pause)
    try:
        laser.start()
        scans = _heard(laser, clock)
        return _judged(exam, laser, scans, link.baudrate)
    except LinkError as error:
        return Finding("laser", State.FAILED, str(error), _SILENT)
    except PortBusyError as error:
        return Finding("laser", State.FAILED, str(error), END_IT)
    except RefusedError as error:
        return Finding("laser", State.FAILED, str(error), "set what is named in the section [laser]")
    finally:
        laser.close()


def _heard(laser: Lms2xx, clock: Clock) -> List[Scan]:
    scans: List[Scan] = []
    end_ns = clock() + round(_LISTENS_S * 1e9)
    while clock() < end_ns:
        scans += laser.read()
    return scans


def _judged(exam: Examination, laser: Lms2xx, scans: List[Scan], baudrate: int) -> Finding:
    name = f"{laser.model or 'a scanner that does not say what it is'}, {baudrate} baud"
    health, limit_s = laser.health, laser.scan_age_limit_s
    if health.state is HealthState.FAILED or not scans:
        reason = health.reason or f"expected scans, got none in {_LISTENS_S:g} s"
        return Finding("laser", State.FAILED, f"{name}: {reason}", _LOOK)
    if health.state is not HealthState.OK:
        differs = laser.status is not None and difference(laser.status, exam.config.laser)
        return Finding("laser", State.WARNING, f"{name}: {health.reason}", _SET if differs else _LOOK)
    allowed_s = min(exam.config.safety.max_scan_age_s, exam.config.navigation.max_scan_age_s)
    if limit_s is not None and allowed_s < limit_s:
        text = f"{name}: expected scans driven by until they are {limit_s:.2f} s old, got {allowed_s:g} s"
        return Finding("laser", State.WARNING, text, "raise max_scan_age_s in [safety] and [navigation]: it will stop")
    return Finding("laser", State.OK, f"{name}, {_in_words(scans)}")


def _in_words(scans: List[Scan]) -> str:
    ranges_m = scans[-1].ranges_m
    seen = ranges_m[np.isfinite(ranges_m)]
    nearest = f"nearest {seen.min():.2f} m" if len(seen) else "nothing near"
    return f"{len(scans) / _LISTENS_S:.1f} scans a second of {len(ranges_m)} beams, {nearest}"
