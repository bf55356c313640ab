# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Answers of the LMS2xx: what a scanner cannot say is refused, whatever its bytes."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.drivers.lms2xx_messages import (
    check_mode_reply,
    check_set_reply,
    parse_configuration,
    parse_status,
    parse_type,
)
from edgefusion.drivers.lms2xx_scan import VARIANTS, Variant
from edgefusion.errors import RefusedError
from edgefusion.sim.lms_scanner_telegrams import status, usual_block


def status_of(variant: Variant) -> bytes:
    return status(usual_block(), variant, 0, 38400) + b"\x10"


@pytest.mark.parametrize("variant", sorted(VARIANTS))
def test_every_variant_that_there_is_is_read(variant: Variant) -> None:
    assert parse_status(status_of(variant)).variant == variant


@pytest.mark.parametrize("variant", [(180, 0), (180, 25), (180, 200), (0, 100), (200, 1)])
def test_a_status_with_a_variant_that_there_is_not_is_refused(variant: tuple[int, int]) -> None:
    with pytest.raises(RefusedError, match=r"status: expected one of \[\(100, 25\), .*got \(\d+, \d+\)"):
        parse_status(status_of(Variant(*variant)))


def test_a_status_that_is_cut_short_is_refused() -> None:
    with pytest.raises(RefusedError, match="status: expected more than 123 bytes, got 100"):
        parse_status(status_of(Variant(180, 100))[:100])


@given(st.binary(min_size=1, max_size=806))
def test_of_any_bytes_nothing_comes_but_a_refusal_or_what_a_scanner_can_be(payload: bytes) -> None:
    with suppress(RefusedError):
        assert parse_status(payload).variant.turns in (1, 2, 4)
    with suppress(RefusedError):
        parse_configuration(payload).changed(0, 1).command()
    for check in (check_mode_reply, parse_type, lambda each: check_set_reply(each, "what")):
        with suppress(RefusedError):
            check(payload)
