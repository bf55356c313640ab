// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>

#include "edgefusion/cells.hpp"
#include "edgefusion/footprint.hpp"
#include "refusal.hpp"
#include "sweeps.hpp"

using namespace edgefusion;

TEST_CASE("numbers are floored, and those that no whole number holds are far away") {
  CHECK(floored(2.0) == 2);
  CHECK(floored(1.999) == 1);
  CHECK(floored(-0.0) == 0);
  CHECK(floored(-1e-9) == -1);
  CHECK(floored(-3.0) == -3);
  for (const double huge : {1e10, 1e300, double(INFINITY)}) {
    CHECK(floored(huge) == 1 << 29);
    CHECK(floored(-huge) == -(1 << 29));
  }
  CHECK(floored(NAN) == -(1 << 29));
}

TEST_CASE("a hull is the same in either sense, and exact beside its edges") {
  const double left[] = {0.2, 0.1, -0.3, 0.1, -0.3, -0.1, 0.2, -0.1},
               right[] = {0.2, -0.1, -0.3, -0.1, -0.3, 0.1, 0.2, 0.1};
  for (const Footprint& hull : {Footprint(left, 4), Footprint(right, 4)}) {
    CHECK(hull.inscribed() == doctest::Approx(0.1));
    CHECK(hull.circumscribed() == doctest::Approx(std::hypot(0.3, 0.1)));
    CHECK(hull.front() == 0.2);
    CHECK(hull.back() == -0.3);
    CHECK(hull.gap(0.5, 0.0) == doctest::Approx(0.3));
    CHECK(hull.gap(0.0, 0.0) == doctest::Approx(-0.1));
    CHECK(hull.gap(0.2, 0.1) == doctest::Approx(0.0));
  }
}

TEST_CASE("a polygon that is no hull is refused") {
  const double corners[] = {1, 0, 0, 1, -1, -1, NAN, 0};
  CHECK(refusal([&] { Footprint(corners, 0); }) == "footprint: expected at least 3 corners, got 0");
  CHECK(refusal([&] { Footprint(corners, 4); }) == "footprint: expected finite numbers, got nan at index 6");
  CHECK(refusal([&] { Footprint(corners, 3); }).empty());
}
