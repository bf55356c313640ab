# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Brings an LMS2xx from whatever state it was left in to the configured one."""

from __future__ import annotations

from edgefusion.config.laser import LaserConfig
from edgefusion.drivers.lms2xx_line import LaserError, LaserLine
from edgefusion.drivers.lms2xx_messages import (
    CENTIMETRES,
    GET_CONFIGURATION,
    INSTALLATION_MODE,
    MILLIMETRES,
    SPEEDS,
    STATUS,
    STOP,
    STREAM_ALL,
    STREAM_PARTIAL,
    TYPE,
    LaserStatus,
    check_mode_reply,
    check_set_reply,
    parse_configuration,
    parse_status,
    parse_type,
    set_variant,
)
from edgefusion.drivers.lms2xx_scan import Variant
from edgefusion.drivers.lms2xx_timing import scan_age_limit_s
from edgefusion.errors import RefusedError

SEARCHED = (9600, 38400, 500000, 19200)
"""What a scanner has after power-on, then what a run that crashed may have left."""

_SETTLE_S = 0.25
_ACKNOWLEDGED_S = 0.12
"""Within 60 ms, and what a read and an adapter take. Who waits longer at wrong speeds misses a scanner's arrival."""
_EEPROM_S = 15.0
_SEARCH_TRIES = 2
_UNITS = {"cm": CENTIMETRES, "mm": MILLIMETRES}
_VARIANTS = {
    181: Variant(180, 100),
    361: Variant(180, 50),
    101: Variant(100, 100),
    201: Variant(100, 50),
    401: Variant(100, 25),
}


def find_speed(line: LaserLine, answer_s: float) -> int:
    """The speed at which the scanner answers; it has stopped streaming then. Raises LaserError where it never does.

    The line's own comes first: a scanner whose plug was out for a moment still streams.
    """
    for baudrate in dict.fromkeys((line.link.baudrate, *SEARCHED)):
        try:
            line.switch(baudrate, 0.0)
            line.ask(STOP, answer_s, _SEARCH_TRIES, _ACKNOWLEDGED_S)
        except (LaserError, RefusedError):  # not at this speed, or the port has it not
            continue
        return baudrate
    raise LaserError(f"{line.link.name}: expected an LMS2xx, got no answer at any of {', '.join(map(str, SEARCHED))}")


def set_speed(line: LaserLine, baudrate: int, answer_s: float) -> None:
    """Scanner and host change their speed; the scanner answers at its old one. Raises LaserError, RefusedError."""
    if line.link.baudrate != baudrate:
        check_mode_reply(line.ask(SPEEDS[baudrate], answer_s))
        line.switch(baudrate, _SETTLE_S)


def set_up(line: LaserLine, config: LaserConfig, answer_s: float) -> LaserStatus:
    """What the scanner is then; it does not stream yet. Raises LinkError, RefusedError for what it does not take."""
    find_speed(line, answer_s)
    set_speed(line, config.baudrate, answer_s)
    status = parse_status(line.ask(STATUS, answer_s))
    variant = _VARIANTS[config.beams]
    if status.variant != variant:
        check_set_reply(line.ask(set_variant(variant), answer_s), f"{config.beams} beams")
    if config.write_eeprom:
        _write_where_it_differs(line, config, answer_s)
    return parse_status(line.ask(STATUS, answer_s))


def read_model(line: LaserLine, answer_s: float) -> str:
    """What it calls itself; empty where it does not say. Raises LinkError for a line that is lost."""
    try:
        return parse_type(line.ask(TYPE, answer_s, tries=1))
    except LaserError:
        return ""


def configured_age_limit_s(config: LaserConfig) -> float:
    """The scan_age_limit_s of a scanner that is set up so."""
    angle, turns = _VARIANTS[config.beams].angle, 1 if config.partial_scans else _VARIANTS[config.beams].turns
    return scan_age_limit_s(angle * turns + 1, turns, config.baudrate)


def start_stream(line: LaserLine, config: LaserConfig, answer_s: float) -> None:
    """Raises LinkError, RefusedError where the scanner does not begin."""
    check_mode_reply(line.ask(STREAM_PARTIAL if config.partial_scans else STREAM_ALL, answer_s))


def difference(status: LaserStatus, config: LaserConfig) -> str:
    """What the scanner's memory says instead of the configuration, in words; empty where they agree."""
    names = {number: name for name, number in _UNITS.items()}
    pairs = (
        ("measuring mode", status.measuring_mode, config.measuring_mode),
        ("unit", names.get(status.unit, str(status.unit)), config.unit),
    )
    return ", ".join(f"{name} {found} instead of {wanted}" for name, found, wanted in pairs if found != wanted)


def _write_where_it_differs(line: LaserLine, config: LaserConfig, answer_s: float) -> None:
    found = parse_configuration(line.ask(GET_CONFIGURATION, answer_s))
    wanted = found.changed(config.measuring_mode, _UNITS[config.unit])
    if wanted != found:
        check_mode_reply(line.ask(INSTALLATION_MODE, answer_s))
        # Once: every try wears the memory out.
        check_set_reply(line.ask(wanted.command(), _EEPROM_S, tries=1), "configuration")
