// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include "edgefusion/polynomial.hpp"

using namespace edgefusion;

namespace {

Polynomial with_roots(const std::vector<double>& roots) {
  Polynomial p{1.0};
  for (const double root : roots) p = multiply(p, {-root, 1.0});
  return p;
}

}  // namespace

TEST_CASE("every simple positive root is found, negative ones are not") {
  const std::vector<double> changes = positive_sign_changes(with_roots({-2.0, 0.5, 1.0, 3.0, 1000.0}));
  REQUIRE(changes.size() == 4);
  CHECK(changes[0] == doctest::Approx(0.5));
  CHECK(changes[1] == doctest::Approx(1.0));
  CHECK(changes[2] == doctest::Approx(3.0));
  CHECK(changes[3] == doctest::Approx(1000.0));
}

TEST_CASE("a curve that stays on one side has no sign change") {
  CHECK(positive_sign_changes(add(with_roots({2.0, 2.0}), {0.01})).empty());
}

TEST_CASE("leading zeros, constants and nothing at all have no sign change") {
  CHECK(positive_sign_changes({}).empty());
  CHECK(positive_sign_changes({1.0, 0.0, 0.0}).empty());
  CHECK(positive_sign_changes({-1.0, 2.0, 0.0}).size() == 1);
}

TEST_CASE("a vanishing leading coefficient puts its root far out, not into the way") {
  const std::vector<double> changes = positive_sign_changes({1.0, -1.0, -1e-12});
  REQUIRE(changes.size() == 1);
  CHECK(changes[0] == doctest::Approx(1.0));
}
