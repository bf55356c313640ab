// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "edgefusion/cost_map.hpp"
#include "refusal.hpp"
#include "sweeps.hpp"

using namespace edgefusion;

namespace {

const WayCost kCost{0.2, 0.7, 4.0};
constexpr double kCell = 0.05;

CostMap computed(const ObstacleMap& map, std::size_t portion = 100'000) {
  CostMap costs(kCost);
  costs.begin(map);
  while (!costs.done()) costs.advance(map, portion);
  return costs;
}

double expected(double apart) {
  if (apart < kCost.blocked) return INFINITY;
  const double near = std::max(0.0, (kCost.comfort - apart) / (kCost.comfort - kCost.blocked));
  return 1.0 + kCost.weight * near * near;
}

std::vector<double> scattered(ObstacleMap& map, unsigned seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  std::vector<double> points;
  for (int i = 0; i < count; ++i) put(map, place(random), place(random));
  for (std::size_t i = 0; i < map.window().size(); ++i)
    if (map.at(i).evidence > 0)
      points.insert(points.end(), {static_cast<double>(map.at(i).x), static_cast<double>(map.at(i).y)});
  return points;
}

double nearest(const std::vector<double>& points, double x, double y) {
  double least = INFINITY;
  for (std::size_t i = 0; i < points.size(); i += 2)
    least = std::min(least, std::hypot(points[i] - x, points[i + 1] - y));
  return least;
}

}  // namespace

TEST_CASE("what a metre costs goes by the distance to the nearest point") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    ObstacleMap map(kCell);
    map.cover(0, 0, 0, 0);
    const std::vector<double> points = scattered(map, seed, 60);
    const CostMap costs = computed(map);
    const MapWindow w = map.window();
    for (std::int32_t r = w.row; r < w.row + w.rows; r += 3) {
      for (std::int32_t c = w.column; c < w.column + w.columns; c += 3) {
        const double apart = nearest(points, (c + 0.5) * kCell, (r + 0.5) * kCell);
        const auto cost = static_cast<double>(costs.at(w.index(c, r), c, r));
        // A cell's nearest point comes to it through its neighbours: now and then another is a trifle nearer.
        const bool exact = cost == doctest::Approx(expected(apart)).epsilon(1e-5);
        const bool trifle = cost <= expected(apart) && cost >= expected(apart + 0.1 * kCell);
        CHECK_MESSAGE((exact || trifle), "seed ", seed, ", cell ", c, ", ", r, ": ", cost, ", at ", apart,
                      " m");
      }
    }
  }
}

TEST_CASE("portions give the same, and a portion of nothing does nothing") {
  ObstacleMap map(kCell);
  map.cover(0, 0, 0, 0);
  scattered(map, 1, 40);
  const CostMap whole = computed(map), portions = computed(map, 1);
  const MapWindow w = map.window();
  for (std::int32_t r = w.row; r < w.row + w.rows; ++r)
    for (std::int32_t c = w.column; c < w.column + w.columns; ++c)
      REQUIRE(whole.at(w.index(c, r), c, r) == portions.at(w.index(c, r), c, r));
  CostMap costs(kCost);
  costs.begin(map);
  CHECK(costs.advance(map, 0) == 0);
  CHECK_FALSE(costs.done());
}

TEST_CASE("where the base failed to get through a metre costs more") {
  ObstacleMap map(kCell);
  map.cover(0, 0, 0, 0);
  const std::size_t here = map.window().index(0, 0);
  CHECK(computed(map).at(here, 0, 0) == 1.0f);
  map.avoid(0.0, 0.0, 0.2);
  CHECK(computed(map).at(here, 0, 0) > 2.0f);
}

TEST_CASE("costs that are none are refused") {
  CHECK(refusal([] { CostMap({-1.0, 0.7, 4.0}); }) ==
        "blocked: expected a finite number of at least 0, got -1");
  CHECK(refusal([] { CostMap({0.2, INFINITY, 4.0}); }) ==
        "comfort: expected a finite number of at least 0, got inf");
  CHECK(refusal([] { CostMap({0.2, 0.2, 4.0}); }) == "comfort: expected more than blocked, 0.2, got 0.2");
}
