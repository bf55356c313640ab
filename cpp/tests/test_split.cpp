// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "edgefusion/dbscan.hpp"
#include "edgefusion/split.hpp"
#include "refusal.hpp"

using namespace edgefusion;

namespace {

constexpr SplitRule kRule{0.01, 0.3, 3};

// A wall 3 m ahead, and before it a box whose front is at `front_m`, as 121 beams from the right to the left see them.
std::vector<double> wall_and_box(double front_m, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, kRule.sigma_m);
  std::vector<double> points;
  for (int i = -60; i <= 60; ++i) {
    const double angle = 0.0087 * i, x = std::abs(std::tan(angle)) * front_m < 0.3 ? front_m : 3.0;
    const double range = x / std::cos(angle) + noise(random);
    points.push_back(range * std::cos(angle));
    points.push_back(range * std::sin(angle));
  }
  return points;
}

std::vector<std::int32_t> split(const std::vector<double>& points) {
  std::vector<std::int32_t> labels(points.size() / 2);
  dbscan(points.data(), labels.size(), kRule.eps, kRule.min_points, labels.data());
  split_clusters(points.data(), labels.size(), kRule, labels.data());
  return labels;
}

}  // namespace

TEST_CASE("a box at a wall is parted from it, the wall stays one on both of its sides") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::vector<std::int32_t> labels = split(wall_and_box(2.8, seed));
    CHECK(labels.front() == labels.back());
    CHECK(labels[60] != labels.front());
    CHECK(labels[56] == labels[60]);
    CHECK(labels[64] == labels[60]);
  }
}

TEST_CASE("a straight wall with nothing before it stays whole") {
  for (unsigned seed = 0; seed < 20; ++seed)
    for (const std::int32_t label : split(wall_and_box(3.0, seed))) CHECK(label == 0);
}

TEST_CASE("no points, and clusters of few, are left as they are") {
  split_clusters(nullptr, 0, kRule, nullptr);
  const std::vector<double> points{1, 0, 1, 0.1, 1, 0.2};
  CHECK(split(points) == std::vector<std::int32_t>{0, 0, 0});
}

TEST_CASE("what cannot be is refused by name") {
  const double points[] = {0.0, std::numeric_limits<double>::infinity()};
  std::int32_t label = 0;
  CHECK(refusal([&] { split_clusters(points, 1, kRule, &label); }) ==
        "points: expected finite numbers, got inf at index 1");
  const double fine[] = {1.0, 1.0};
  CHECK(refusal([&] { split_clusters(fine, 1, {0.0, 0.3, 3}, &label); }) ==
        "sigma_m: expected a finite number above 0, got 0");
  label = 7;
  CHECK(refusal([&] { split_clusters(fine, 1, kRule, &label); }) ==
        "labels: expected -1 to 0, got 7 at index 0");
}
