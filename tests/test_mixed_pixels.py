# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Beams between two surfaces are unknown, all others stay as they were."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.navigation.mixed_pixels import EDGE_M, without_mixed

STEP = math.radians(0.5)
RANGES = st.one_of(st.floats(0.0, 8.0, width=32), st.sampled_from([math.inf, -math.inf, math.nan]))


def cleaned(ranges_m, bearings=None):
    ranges_m = np.asarray(ranges_m, np.float32)
    return without_mixed(ranges_m, STEP * np.arange(len(ranges_m)) if bearings is None else bearings)


def dropped(ranges_m, bearings=None):
    """The beams that were known and no longer are; nothing else may have changed."""
    before = np.asarray(ranges_m, np.float32)
    after = cleaned(ranges_m, bearings)
    gone = np.isnan(after) & ~np.isnan(before)
    np.testing.assert_array_equal(after[~gone], before[~gone])
    return np.nonzero(gone)[0].tolist()


@pytest.mark.parametrize(
    ("ranges_m", "expected"),
    [
        ([2, 2, 2, 2.7, 4, 4, 4], [3]),
        ([4, 4, 4, 2.7, 2, 2, 2], [3]),
        ([2, 2, 2, 2.05, 4, 4, 4], []),  # the noise of the nearer surface
        ([2, 2, 2, 3.95, 4, 4, 4], []),
        ([2, 2, 2, 1.5, 4, 4, 4], []),  # nearer than both: an obstacle
        ([4, 4, 4, 1.0, 4, 4, 4], []),
        ([2, 2, 2, 5.0, 4, 4, 4], []),  # farther than both hides nothing
        ([2, 2, 2, 2.7, math.inf, math.inf], [3]),  # between a thing and nothing
        ([math.inf, 2.7, 2, 2], [1]),
        ([2, 2, 2, math.inf, 4, 4], []),
        ([2, 2, math.nan, 2.7, math.nan, 4, 4], [3]),  # beams that say nothing are no neighbours
        ([2, 3], []),
        ([2.5], []),
        ([], []),
    ],
)
def test_a_beam_between_its_neighbours_is_dropped_all_others_stay(ranges_m, expected):
    assert dropped(ranges_m) == expected


@pytest.mark.parametrize("noise_m", [0.0, 0.005])
def test_a_wall_that_is_looked_along_stays(noise_m):
    angles = np.arange(math.radians(3), math.radians(12), STEP)  # each beam 0.1 m and more behind the last
    noise = noise_m * np.random.default_rng(0).standard_normal(len(angles))
    ranges_m = 0.4 / np.sin(angles) + noise
    assert (np.abs(np.diff(ranges_m)) > EDGE_M).sum() >= 10
    assert len(dropped(ranges_m)) <= (0 if noise_m == 0 else 1)


def test_the_edge_before_a_wall_that_is_looked_along_is_dropped():
    wall = 0.4 / np.sin(np.arange(math.radians(3), math.radians(8), STEP))
    assert dropped([8, 8, 8, 7.8, *wall]) in ([3], [3, 4])  # of the wall one beam at most


@given(st.lists(RANGES, max_size=12), st.randoms(use_true_random=False))
def test_the_order_of_the_beams_does_not_matter(ranges_m, random):
    order = list(range(len(ranges_m)))
    random.shuffle(order)
    ranges = np.asarray(ranges_m, np.float32)
    shuffled = cleaned(ranges[order], STEP * np.asarray(order, float))
    np.testing.assert_array_equal(shuffled, cleaned(ranges)[order])


@given(st.lists(RANGES, max_size=12))
def test_a_scan_that_is_read_backwards_says_the_same(ranges_m):
    np.testing.assert_array_equal(cleaned(ranges_m[::-1]), cleaned(ranges_m)[::-1])


@given(st.lists(RANGES, max_size=12))
def test_nothing_is_made_up_and_the_nearest_stays(ranges_m):
    before = np.asarray(ranges_m, np.float32)
    dropped(ranges_m)
    after = cleaned(ranges_m)
    assert np.nanmin(after, initial=np.inf) == np.nanmin(before, initial=np.inf)


def test_what_was_given_is_not_changed():
    ranges_m = np.array([2, 2, 2.7, 4, 4], np.float32)
    cleaned(ranges_m)
    assert ranges_m[2] == np.float32(2.7)
