// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "edgefusion/nearest_range.hpp"
#include "refusal.hpp"

using namespace edgefusion;

namespace {

constexpr double kSigma = 0.01;

std::vector<double> noisy(const std::vector<double>& truth, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, kSigma);
  std::vector<double> ranges = truth;
  for (double& range : ranges) range += noise(random);
  return ranges;
}

}  // namespace

TEST_CASE("over a flat face the minimum is two sigma too near, the corrected range is within one") {
  std::mt19937 random(7);
  const std::vector<double> truth(31, 2.0);
  double minimum = 0.0, corrected = 0.0;
  constexpr int kTrials = 400;
  for (int i = 0; i < kTrials; ++i) {
    const std::vector<double> ranges = noisy(truth, random);
    minimum += *std::min_element(ranges.begin(), ranges.end()) / kTrials;
    corrected += nearest_range(ranges.data(), ranges.size(), kSigma).range_m / kTrials;
  }
  CHECK(minimum < 2.0 - 1.9 * kSigma);
  CHECK(std::abs(corrected - 2.0) < 0.9 * kSigma);
}

TEST_CASE("the truth lies within two sigma nearly always") {
  std::mt19937 random(11);
  std::vector<double> truth;  // a cylinder's front
  for (int i = -8; i <= 8; ++i) truth.push_back(1.5 + 0.0015 * i * i);
  int within = 0;
  constexpr int kTrials = 500;
  for (int i = 0; i < kTrials; ++i) {
    const std::vector<double> ranges = noisy(truth, random);
    const NearestRange nearest = nearest_range(ranges.data(), ranges.size(), kSigma);
    within += std::abs(nearest.range_m - 1.5) <= 2 * nearest.sigma_m;
  }
  CHECK(within >= 0.92 * kTrials);
}

TEST_CASE("one beam is its own nearest range, with its own noise") {
  const double range = 3.0;
  const NearestRange nearest = nearest_range(&range, 1, kSigma);
  CHECK(nearest.range_m == doctest::Approx(3.0).epsilon(1e-4));
  CHECK(nearest.sigma_m == doctest::Approx(1.5 * kSigma).epsilon(0.05));
  CHECK(nearest.index == 0);
}

TEST_CASE("a slanted face is nearest half a step beyond its last beam") {
  const std::vector<double> ranges{2.5, 2.4, 2.3, 2.2, 2.1, 2.0};
  const NearestRange nearest = nearest_range(ranges.data(), ranges.size(), 1e-4);
  CHECK(nearest.range_m == doctest::Approx(1.95).epsilon(1e-3));
  CHECK(nearest.index == 5);
}

TEST_CASE("no ranges, ranges that are not finite and no noise are refused by name") {
  const auto message = [](const std::vector<double>& ranges, double sigma) {
    return refusal([&] { nearest_range(ranges.data(), ranges.size(), sigma); });
  };
  CHECK(message({}, kSigma) == "ranges_m: expected at least one range, got none");
  CHECK(message({1, 2, NAN}, kSigma) == "ranges_m: expected finite numbers, got nan at index 2");
  CHECK(message({1, INFINITY}, kSigma) == "ranges_m: expected finite numbers, got inf at index 1");
  CHECK(message({1}, 0.0) == "sigma_m: expected a finite number above 0, got 0");
  for (const double sigma : {-1.0, double(NAN), double(INFINITY)})
    CHECK(message({1}, sigma).find("sigma_m: expected") == 0);
}
