# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Scan telegrams of the LMS2xx: count and unit from each, special values, flags, health, times."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.drivers.lms2xx_scan import RawScan, parse_scan, range_max_m, ranges_of
from edgefusion.drivers.lms2xx_status import health_of
from edgefusion.drivers.lms2xx_telegram import encode
from edgefusion.drivers.lms2xx_timing import (
    TURN_NS,
    backlog_ns,
    beam_times,
    first_byte_ns,
    line_ns,
    mean_wait_ns,
    scan_age_limit_s,
    silence_limit_s,
    stamped,
)
from edgefusion.errors import RefusedError
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.types import HealthState

CM, MM, DM = 0x0000, 0x4000, 0x8000
PARTIAL = 0x2000


def payload(values: list[int], bits: int = MM, status: int = 0x10, rest: bytes = b"") -> bytes:
    header = (len(values) | bits).to_bytes(2, "little")
    return b"\xb0" + header + np.array(values, "<u2").tobytes() + rest + bytes([status])


def raw(count: int, bits: int = MM) -> RawScan:
    return parse_scan(payload([1000] * count, bits))


def test_a_half_degree_scan_in_millimetres_has_its_documented_header() -> None:
    telegram = encode(payload([1000] * 361), 0x80)
    assert telegram[:7] == bytes.fromhex("02 80 D6 02 B0 69 41")
    assert len(telegram) == 732


@pytest.mark.parametrize(
    ("count", "angle", "step", "turns", "size"),
    [
        (181, 90, 1, 1, 372),
        (361, 90, 0.5, 2, 732),
        (101, 50, 1, 1, 212),
        (201, 50, 0.5, 2, 412),
        (401, 50, 0.25, 4, 812),
    ],
)
def test_the_count_tells_the_angles(count: int, angle: int, step: float, turns: int, size: int) -> None:
    scan = raw(count)
    assert (math.degrees(scan.angle_min), math.degrees(scan.angle_increment)) == pytest.approx((-angle, step))
    assert scan.variant.turns == turns
    assert len(encode(payload([1000] * count), 0x80)) == size


@pytest.mark.parametrize(("unit", "metres"), [(CM, 12.34), (MM, 1.234), (DM, 123.4)])
def test_the_unit_is_the_telegrams(unit: int, metres: float) -> None:
    assert ranges_of(parse_scan(payload([1234] * 181, unit)), 0) == pytest.approx(metres)


@pytest.mark.parametrize(
    ("mode", "top"), [(0, 8191), (1, 8191), (2, 8191), (3, 16383), (4, 16383), (5, 32767), (6, 32767)]
)
def test_too_far_is_infinite_and_every_other_special_value_unknown(mode: int, top: int) -> None:
    special = [top - less for less in (0, 1, 2, 4, 5)]
    scan = parse_scan(payload([*special, top - 8, top - 9] + [0] * 174))
    ranges = ranges_of(scan, mode)
    assert np.isnan(ranges[:5]).all()
    assert ranges[5] == np.inf
    assert ranges[6] == pytest.approx((top - 9) / 1000)
    assert range_max_m(scan, mode) == pytest.approx((top - 8) / 1000)


@pytest.mark.parametrize(("mode", "flags"), [(0, 0xE000), (3, 0xC000), (5, 0x8000)])
def test_flags_are_no_part_of_the_range(mode: int, flags: int) -> None:
    assert ranges_of(parse_scan(payload([1500 | flags] * 181)), mode) == pytest.approx(1.5)


@pytest.mark.parametrize("mode", [7, 0x0F, 0x3F])
def test_a_mode_whose_values_are_not_known_to_be_ranges_is_refused(mode: int) -> None:
    with pytest.raises(RefusedError, match=f"measuring mode: expected 0 to 6, got {mode}"):
        ranges_of(raw(181), mode)


@pytest.mark.parametrize(
    ("count", "offset", "first"),
    [(181, 0, -90), (180, 2, -89.5), (181, 2, -89.5), (101, 0, -50), (100, 1, -49.75), (100, 3, -49.25)],
)
def test_a_partial_scan_begins_between_the_degrees(count: int, offset: int, first: float) -> None:
    scan = raw(count, MM | PARTIAL | offset << 11)
    assert scan.partial
    assert math.degrees(scan.angle_min) == pytest.approx(first)
    assert math.degrees(scan.angle_increment) == pytest.approx(1)
    assert beam_times(scan).max() - beam_times(scan).min() == pytest.approx((count - 1) / 360 * TURN_NS, abs=2)


def test_real_time_indices_are_skipped() -> None:
    scan = parse_scan(payload([1000] * 181, rest=b"\x07", status=0x90))
    assert (len(scan.values), scan.status) == (181, 0x90)


@pytest.mark.parametrize(
    ("bad", "expected"),
    [
        (b"", "at least 4 bytes from 0xB0 on, got none"),
        (b"\xb1\x00\x00\x10", "from 0xB0 on, got b1000010"),
        (payload([0] * 181)[:-3], "expected 366 or 367 bytes for 181, got 363"),
        (payload([0] * 181, 0xC000), "expected a unit from 0 to 2, got 3"),
        (payload([0] * 100), r"expected one of \[101, 181, 201, 361, 401\] beams, got 100"),
        (payload([0] * 180, PARTIAL), r"partial scan at 0/4 of a degree: expected one of \[101, 181\] beams, got 180"),
        (payload([0] * 361, 2 << 11), r"scan at 2/4 of a degree: expected one of \[\] beams, got 361"),
    ],
)
def test_what_no_scan_has_is_refused(bad: bytes, expected: str) -> None:
    with pytest.raises(RefusedError, match=expected):
        parse_scan(bad)


@given(st.binary(max_size=900), st.integers(0, 6))
def test_any_payload_is_a_scan_or_refused(data: bytes, mode: int) -> None:
    try:
        scan = parse_scan(b"\xb0" + data)
    except RefusedError:
        return
    ranges = ranges_of(scan, mode)
    assert len(ranges) == len(scan.values) == len(beam_times(scan))


def test_a_status_of_a_type_6_is_well_and_the_rest_is_health() -> None:
    assert health_of(0x10).state is HealthState.OK
    assert health_of(0x90).reason == "front window polluted"
    assert health_of(0x50).reason == "implausible values: dazzled"
    assert health_of(0x12).state is health_of(0x90).state is HealthState.DEGRADED
    assert (health_of(0x13).state, health_of(0x14).reason) == (HealthState.FAILED, "reports: fatal")


def test_a_half_degree_telegram_takes_190_ms_at_38400() -> None:
    assert line_ns(732, 38400) / 1e6 == pytest.approx(190.6, abs=0.1)
    with pytest.raises(RefusedError, match="baud: expected at least 1, got 0"):
        line_ns(1, 0)


@pytest.mark.parametrize("baud", [38400, 500000])
@pytest.mark.parametrize("late", [0, 100])
def test_the_first_bytes_time_does_not_depend_on_how_much_came_with_it(baud: int, late: int) -> None:
    began_ns = 5_000_000_000
    received_ns = began_ns + line_ns(732 + late, baud)
    assert first_byte_ns(received_ns, 1000, 1732 + late, baud) == pytest.approx(began_ns, abs=2)


def test_beam_times_are_the_simulators() -> None:
    np.testing.assert_allclose(beam_times(raw(361)), SimLaser(LaserSpec()).beam_dt_ns, atol=1)
    spec = LaserSpec(beams=181, angle_increment=math.radians(1), interlaced=False)
    np.testing.assert_allclose(beam_times(raw(181)), SimLaser(spec).beam_dt_ns, atol=1)


@pytest.mark.parametrize("count", [101, 181, 201, 361, 401])
def test_the_last_beam_was_measured_when_the_first_byte_came(count: int) -> None:
    scan = stamped(raw(count), 0, 5_000_000_000)
    assert scan.beam_dt_ns is not None
    assert scan.beam_dt_ns[count // 2] == 0
    assert (scan.stamp_ns + scan.beam_dt_ns).max() == 5_000_000_000
    assert scan.range_max_m == pytest.approx(8.183)


@pytest.mark.parametrize(
    ("beams", "turns", "baud", "silence_s", "age_s"),
    [(361, 2, 38400, 0.4766, 0.7439), (361, 2, 500000, 0.15, 0.158), (181, 1, 500000, 0.15, 0.1041)],
)
def test_limits_come_of_the_line_and_the_mirror(beams, turns, baud, silence_s: float, age_s: float) -> None:
    assert silence_limit_s(beams, turns, baud) == pytest.approx(silence_s, abs=0.0005)
    assert scan_age_limit_s(beams, turns, baud) == pytest.approx(age_s, abs=0.0005)


def test_only_over_a_line_slower_than_the_mirror_a_scan_waits() -> None:
    assert mean_wait_ns(732, 2, 38400) == pytest.approx(TURN_NS, abs=1)
    assert mean_wait_ns(372, 1, 38400) == pytest.approx(TURN_NS / 2, abs=1)
    assert mean_wait_ns(732, 2, 500000) == mean_wait_ns(372, 1, 500000) == 0


@given(st.sampled_from([38400, 500000]), st.integers(0, 20 * 732))
def test_a_backlog_is_as_old_as_what_came_since(baud: int, waiting: int) -> None:
    period_ns = max(2 * TURN_NS, line_ns(732, baud))
    ended_ns = [k * period_ns for k in range(21)]  # each telegram's last byte, from that of the one in question
    came = [end + line_ns(rest, baud) - line_ns(732, baud) for end in ended_ns[1:] for rest in range(1, 733)]
    at_least_ns = came[waiting - 1] if waiting else 0
    assert backlog_ns(waiting, 732, 2, baud) == pytest.approx(at_least_ns, abs=50)
