// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "edgefusion/navigation_function.hpp"
#include "refusal.hpp"
#include "sweeps.hpp"

using namespace edgefusion;

namespace {

const WayCost kCost{0.2, 0.7, 4.0};
constexpr double kInfinity = INFINITY;

ObstacleMap covering(double x, double y) {
  ObstacleMap map(0.1);
  map.cover(0, 0, x, y);
  return map;
}

std::vector<double> way(const NavigationFunction& function, double x, double y, double length,
                        double reach = 0) {
  std::vector<double> points;
  function.potential().way(x, y, length, reach, points);
  return points;
}

NavigationFunction computed(const ObstacleMap& map, double x, double y, std::size_t portion = 1'000'000) {
  NavigationFunction function(kCost);
  function.begin(map, x, y, 0.05, 0, 0);
  while (!function.advance(map, portion)) REQUIRE(function.running());
  return function;
}

}  // namespace

TEST_CASE("nothing begun is nothing known, and advancing it does nothing") {
  NavigationFunction function(kCost);
  CHECK_FALSE(function.running());
  CHECK_FALSE(function.advance(ObstacleMap(0.1), 10));
  CHECK(function.potential().value(0, 0) == kInfinity);
  CHECK(function.potential().descent(0, 0) == std::pair(0.0, 0.0));
  CHECK(way(function, 0, 0, 1).empty());
}

TEST_CASE("a portion of no cells does nothing, portions of one end, and are as one go") {
  const ObstacleMap map = covering(1, 0);
  NavigationFunction function(kCost);
  function.begin(map, 1, 0, 0.05, 0, 0);
  for (int i = 0; i < 1000; ++i) CHECK_FALSE(function.advance(map, 0));
  CHECK(computed(map, 1, 0, 1).potential().value(-0.7, 0.3) ==
        computed(map, 1, 0).potential().value(-0.7, 0.3));
}

TEST_CASE("goals on the borders of cells and in the window's corners are reached") {
  const ObstacleMap map = covering(2, 2);
  const MapWindow w = map.window();
  const double low = w.column * 0.1 + 1e-6, high = (w.column + w.columns) * 0.1 - 1e-6;
  for (const auto& [x, y] : {std::pair(1.0, 1.0), std::pair(low, low), std::pair(high, high)}) {
    const NavigationFunction function = computed(map, x, y);
    CHECK(function.potential().outcome == Outcome::kReached);
    CHECK(function.potential().value(0, 0) == doctest::Approx(std::hypot(x, y)).epsilon(0.05));
    const std::vector<double> points = way(function, 0, 0, 50);
    CHECK(points[points.size() - 2] == x);
    CHECK(points.back() == y);
  }
}

TEST_CASE("a way of length 0 is its beginning, one at the goal is the goal") {
  const NavigationFunction function = computed(covering(1, 0), 1, 0);
  CHECK(way(function, 0.25, 0.5, 0) == std::vector<double>{0.25, 0.5});
  CHECK(way(function, 1, 0, 5) == std::vector<double>{1, 0, 1, 0});
  CHECK(way(function, 0.25, 0.5, -1) == std::vector<double>{0.25, 0.5});
}

TEST_CASE("far off the map nothing is known, and nothing overflows") {
  const NavigationFunction function = computed(covering(1, 0), 1, 0);
  for (const double far : {1e5, 1e9, 1e12, 1e300, kInfinity, double(NAN)})
    for (const double x : {far, -far}) {
      CHECK(function.potential().value(x, 0) == kInfinity);
      CHECK(function.potential().descent(0, x) == std::pair(0.0, 0.0));
      CHECK(way(function, x, 0, 1, 1).empty());
    }
  CHECK_FALSE(way(function, 1e3, 0, 1, 1e300).empty());  // the nearest that is known
}

TEST_CASE("a goal outside of the window is approached from its border, a base outside has no way") {
  const ObstacleMap map = covering(0, 0);
  CHECK(computed(map, 9e4, 0).potential().outcome == Outcome::kReached);
  NavigationFunction function(kCost);
  function.begin(map, 0, 0, 0.05, 500, 0);
  CHECK(function.advance(map, 1'000'000));
  CHECK(function.potential().outcome == Outcome::kEnclosed);
}

TEST_CASE("a map without a window, and one of a single cell") {
  CHECK(computed(ObstacleMap(0.1), 1, 0).potential().outcome == Outcome::kOccupied);
  ObstacleMap single(100.0);
  single.cover(0, 0, 0, 0);
  CHECK(computed(single, 1, 1).potential().outcome == Outcome::kReached);
}

TEST_CASE("a map that moves while it is computed is begun anew") {
  ObstacleMap map = covering(0, 0);
  NavigationFunction function(kCost);
  function.begin(map, 1, 0, 0.05, 0, 0);
  function.advance(map, 5000);
  map.cover(30, 0, 30, 0);
  while (!function.advance(map, 5000)) REQUIRE(function.running());
  CHECK(function.potential().value(0, 0) == doctest::Approx(1.0).epsilon(0.05));
}

TEST_CASE("goals and ways that are none are refused") {
  const ObstacleMap map = covering(0, 0);
  NavigationFunction function = computed(map, 0, 0);
  for (const double bad : {kInfinity, double(NAN), 1.01e5, -1e300})
    CHECK(refusal([&] { function.begin(map, bad, 0, 0.05, 0, 0); }).find("goal, tolerance, base: expected") ==
          0);
  CHECK(refusal([&] { function.begin(map, 0, 0, -1, 0, 0); }) == "tolerance: expected at least 0, got -1");
  CHECK(refusal([&] { way(function, 0, 0, kInfinity); }) ==
        "length, reach: expected finite numbers, got inf at index 0");
  CHECK_FALSE(function.running());
}
