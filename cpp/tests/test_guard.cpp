// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "edgefusion/guard.hpp"
#include "refusal.hpp"
#include "sweeps.hpp"

using namespace edgefusion;

namespace {

const Ramps kRamps{0.3, 1.7};
const Motion kRest{{0, 0, 0}, 0, 0};

ObstacleMap seen_ground() {
  ObstacleMap map(0.05);
  map.cover(0, 0, 0, 0);
  see(map, 0, 0, 3);
  return map;
}

}  // namespace

TEST_CASE("a guard that never looked, and one that saw nothing, lets pass what ground was seen for") {
  const ObstacleMap map = seen_ground();
  Guard guard(pioneer(), kRamps);
  CHECK(guard.gap({0, 0, 0}) == INFINITY);
  CHECK_FALSE(guard.stirs());
  CHECK(guard.free(map, kRest, {0.3, 0.1}, 0.2, 0.02, 1.0));
  guard.look(map, 0, 0, 3, nullptr, 0);
  CHECK(guard.free(map, kRest, {-0.3, 0.1}, 0.2, 0.02, 1.0));
  CHECK_FALSE(guard.free(ObstacleMap(0.05), kRest, {0.3, 0}, 0.2, 0.02, 0));
}

TEST_CASE("a wall ahead stops what cannot brake before it, and nothing else") {
  const ObstacleMap map = seen_ground();
  Guard guard(pioneer(), kRamps);
  const double wall[] = {0.51, 0, 0, 0};
  guard.look(map, 0, 0, 3, wall, 1);
  CHECK(guard.gap({0, 0, 0}) == doctest::Approx(0.3));
  CHECK(guard.free(map, {{0, 0, 0}, 0.40, 0}, {0, 0}, 0, 0.02, 0));
  CHECK_FALSE(guard.free(map, {{0, 0, 0}, 0.43, 0}, {0, 0}, 0, 0.02, 0));
  CHECK(guard.free(map, {{0, 0, 0}, -0.43, 0}, {0, 0}, 0, 0.02, 0));
}

TEST_CASE("what is far away is of no account, whoever is there") {
  const ObstacleMap map = seen_ground();
  Guard guard(pioneer(), kRamps);
  const double far[] = {1e300, 0, -1e300, 0, -1e9, 1e12, 3, 3};
  guard.look(map, 0, 0, 1e300, far, 2);
  CHECK(guard.fits({1e12, 1e300, 1e9}, 0.1));
  CHECK(guard.free(map, kRest, {0.2, 0}, 0.1, 0.02, 0));
  CHECK_FALSE(guard.free(map, {{1e9, 0, 0}, 0, 0}, {0.2, 0}, 0.1, 0.02, 0));  // nobody saw the ground there
}

TEST_CASE("a hold of no time is a stop, and commands without end are refused") {
  const ObstacleMap map = seen_ground();
  const Guard guard(pioneer(), kRamps);
  CHECK(guard.free(map, kRest, {1e6, 1e6}, 0, 0.02, 0));
  for (const double bad : {double(NAN), double(INFINITY)}) {
    CHECK_FALSE(refusal([&] { guard.free(map, kRest, {bad, 0}, 0.1, 0.02, 0); }).empty());
    CHECK_FALSE(refusal([&] { guard.free(map, kRest, {0, bad}, 0.1, 0.02, 0); }).empty());
    CHECK_FALSE(refusal([&] { guard.free(map, {{0, 0, 0}, bad, 0}, {0, 0}, 0.1, 0.02, 0); }).empty());
    CHECK_FALSE(refusal([&] { guard.free(map, kRest, {0, 0}, bad, 0.02, 0); }).empty());
    CHECK_FALSE(refusal([&] { guard.free(map, kRest, {0, 0}, 0.1, 0.02, bad); }).empty());
    CHECK_FALSE(refusal([&] { followed(kRest, {0, 0}, kRamps, bad); }).empty());
  }
}

TEST_CASE("the room to keep is the margin, or hardly less than there is") {
  CHECK(kept(0.5, 0.02) == 0.02);
  CHECK(kept(0.02, 0.02) == 0.02);
  for (const double gap : {0.019, 0.01, 0.003, 0.0, -0.1}) {
    CHECK(kept(gap, 0.02) <= gap);
    CHECK(kept(gap, 0.02) >= gap - 0.003);
  }
}
