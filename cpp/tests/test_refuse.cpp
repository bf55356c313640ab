// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "edgefusion/refuse.hpp"
#include "refusal.hpp"

using namespace edgefusion;

TEST_CASE("a number is shown as short as tells it from all others") {
  CHECK(shown(1.0) == "1");
  CHECK(shown(0.1) == "0.1");
  CHECK(shown(0.1f) == "0.1");
  CHECK(shown(1.0000001) == "1.0000001");
  CHECK(shown(std::nextafter(1.0, 2.0)) == "1.0000000000000002");
  CHECK(shown(1e300) == "1e+300");
  CHECK(shown(-std::numeric_limits<double>::infinity()) == "-inf");
  CHECK(shown(-std::numeric_limits<double>::quiet_NaN()) == "nan");
}

TEST_CASE("a refusal is put together from its parts") {
  CHECK(refusal([] { refuse("n: expected ", 1.5, ", got ", 2, std::string(" or "), -3L); }) ==
        "n: expected 1.5, got 2 or -3");
}

TEST_CASE("a number that is not finite is refused by its index") {
  const double values[] = {0.0, 1e308, NAN, INFINITY};
  CHECK(refusal([&] { expect_finite("v", values, 2); }) == "");
  CHECK(refusal([&] { expect_finite("v", values, 4); }) == "v: expected finite numbers, got nan at index 2");
}
