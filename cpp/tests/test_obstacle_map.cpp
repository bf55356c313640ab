// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "edgefusion/obstacle_map.hpp"
#include "refusal.hpp"
#include "sweeps.hpp"

using namespace edgefusion;

namespace {

constexpr float kFree = INFINITY;
const double kFar[] = {1e5, 1e9, 1e12, 1e300, double(INFINITY), double(NAN)};

ObstacleMap about_origin(double cell = 0.05) {
  ObstacleMap map(cell);
  map.cover(0, 0, 0, 0);
  return map;
}

std::vector<double> points(const ObstacleMap& map, double x = 0, double y = 0, double reach = 100) {
  std::vector<double> found;
  map.points_near(x, y, reach, 0.0, found);
  return found;
}

}  // namespace

TEST_CASE("a map without a window keeps nothing, and nothing is wrong with that") {
  ObstacleMap map(0.05);
  insert(map, {0, 0, 0}, {1.0f, kFree});
  map.stand(pioneer(), {0, 0, 0}, 0.02);
  map.avoid(0, 0, 1);
  CHECK(points(map).empty());
  CHECK_FALSE(map.seen(0, 0));
  CHECK(map.window().size() == 0);
}

TEST_CASE("no beams change nothing") {
  ObstacleMap map = about_origin();
  map.insert({nullptr, nullptr, 0, 0.0, 0.1, 0.0, 9.0}, 0);
  CHECK(points(map).empty());
}

TEST_CASE("points in the window's first and last cells are kept, and those beside them are not") {
  ObstacleMap map = about_origin();
  const MapWindow w = map.window();
  const double first = w.column * 0.05, last = (w.column + w.columns) * 0.05;
  put(map, first + 0.001, 0.0);
  put(map, last - 0.001, 0.0);
  CHECK(points(map).size() == 4);
  put(map, first - 0.001, 0.0);
  put(map, last + 0.001, 0.0);
  CHECK(points(map).size() == 4);
  CHECK(map.seen(first + 0.001, 0.0));
  CHECK_FALSE(map.seen(first - 0.001, 0.0));
}

TEST_CASE("beams along the borders of cells, through their corners and out of the window end") {
  ObstacleMap map = about_origin(0.0625);  // of which sums are exact
  for (int eighth = 0; eighth < 8; ++eighth)
    insert(map, {0.125, 0.25, eighth * std::acos(-1.0) / 4}, {kFree}, 0, 0.1, 10);
  CHECK(map.seen(1.0, 0.25));
  CHECK(map.seen(-3.0, 0.25));
  CHECK(map.seen(2.126, 2.251));
  insert(map, {-50, 0, 0}, {kFree});
  insert(map, {0, 0, 0}, {100.0f, kFree}, 0, 3.0, 1e9);
  CHECK(points(map).empty());
}

TEST_CASE(
    "noise of a surface that reaches into the next cell is taken for the surface, other things are not") {
  ObstacleMap map = about_origin();
  for (int i = 0; i < 45; ++i) put(map, 1.01, 0.02);
  put(map, 0.985, 0.02);  // 2.5 cm before it
  const std::vector<double> one = points(map);
  REQUIRE(one.size() == 4);
  for (const std::size_t x : {0, 2}) CHECK(one[x] == doctest::Approx(1.01).epsilon(0.001));
  put(map, 1.01, -0.02);  // its corner, 4 cm aside
  put(map, 0.94, 0.02);   // 7 cm before it
  const std::vector<double> all = points(map);
  REQUIRE(all.size() == 8);
  CHECK(std::count_if(all.begin(), all.end(), [](double v) { return std::abs(v + 0.02) < 1e-6; }) == 1);
  CHECK(std::count_if(all.begin(), all.end(), [](double v) { return std::abs(v - 0.94) < 1e-6; }) == 1);
}

TEST_CASE("the more beams met a thing, the less is put down to noise") {
  ObstacleMap map = about_origin();
  for (int i = 0; i < 40; ++i) put(map, 1.01, 0.02);
  for (int i = 0; i < 25; ++i) put(map, 0.985, 0.02);  // twice each
  const std::vector<double> found = points(map);
  REQUIRE(found.size() == 4);
  CHECK(std::min(found[0], found[2]) == doctest::Approx(0.985 + 0.035 / std::sqrt(50.0)).epsilon(1e-4));
}

TEST_CASE("a thing beside where another was, which has gone, counts at once") {
  ObstacleMap map = about_origin();
  for (int i = 0; i < 45; ++i) put(map, 1.045, 0.02);
  for (int i = 0; i < 30; ++i) insert(map, {0, 0.02, 0}, {2.0f});  // beams come through
  CHECK(points(map).size() == 2);                                  // the wall behind
  put(map, 1.055, 0.02);
  CHECK(points(map).size() == 4);
}

TEST_CASE("a point on the corner of four cells is in one of them") {
  ObstacleMap map = about_origin(0.0625);
  put(map, 0.125, 0.125);
  CHECK(points(map) == std::vector<double>{0.125, 0.125});
  CHECK(points(map, 0.125, 0.125, 0.0).size() == 2);
}

TEST_CASE("asking far away finds nothing, and overflows nothing") {
  ObstacleMap map = about_origin();
  put(map, 1, 1);
  for (const double far : kFar)
    for (const double x : {far, -far}) {
      CHECK_FALSE(map.seen(x, 0));
      CHECK_FALSE(map.seen(0, x));
      CHECK(map.age(x, x, 0) == INFINITY);
      CHECK(points(map, x, 0, 1).empty());
      map.stand(pioneer(), {x, 0, 0}, 0.02);
    }
  CHECK(points(map, 0, 0, 1e300).size() == 2);
}

TEST_CASE("places that no map holds are refused") {
  ObstacleMap map = about_origin();
  for (const double far : {1.01e5, 1e9, 1e12, 1e300, double(INFINITY), double(NAN)}) {
    CAPTURE(far);
    CHECK(refusal([&] { map.cover(far, 0, 0, 0); }).find("base, target: expected") == 0);
    CHECK(refusal([&] { map.cover(0, 0, 0, -far); }).find("base, target: expected") == 0);
    CHECK(refusal([&] { insert(map, {-far, 0, 0}, {kFree}); }).find("poses: expected") == 0);
  }
  CHECK(refusal([&] { map.avoid(NAN, 0, 1); }) ==
        "x, y, radius: expected finite numbers, got nan at index 0");
  for (const double cell : {0.0, -1.0, 0.009, double(NAN), double(INFINITY)})
    CHECK(refusal([&] { ObstacleMap{cell}; }).find("cell: expected a finite number of at least 0.01") == 0);
}

TEST_CASE("a base at the rim of what a map holds and a target at the other give a window about the base") {
  ObstacleMap map(0.05);
  map.cover(1e5, -1e5, -1e5, 1e5);
  CHECK(map.window().columns * 0.05 == doctest::Approx(60));
  CHECK(map.window().holds(map.column_of(1e5), map.column_of(-1e5)));
  map.cover(-1e5, 1e5, -1e5, 1e5);
  CHECK(map.window().holds(map.column_of(-1e5), map.column_of(1e5)));
}

TEST_CASE("cells larger than the space that is to be covered work, too") {
  ObstacleMap map(1e4);
  map.cover(0, 0, 3, 3);
  put(map, 10, 10);
  CHECK(points(map).size() == 2);
}

TEST_CASE("what a cell shows reaches as far as its points do, from whichever side they are seen") {
  for (const double side : {1.0, -1.0}) {
    ObstacleMap map = about_origin();
    const double heading = side > 0 ? 0.0 : std::acos(-1.0);
    for (int round = 0; round < 3; ++round)
      for (double y = 0.002; y < 0.04; y += 0.004) insert(map, {1.01 - side, y, heading}, {1.0f});
    const std::vector<double> found = points(map);
    double low = 1.0, high = -1.0;
    for (std::size_t i = 1; i < found.size(); i += 2) {
      low = std::min(low, found[i]);
      high = std::max(high, found[i]);
    }
    CHECK(std::abs(low - 0.002) < 0.003);
    CHECK(std::abs(high - 0.038) < 0.003);
    for (std::size_t i = 0; i < found.size(); i += 2) CHECK(found[i] == doctest::Approx(1.01).epsilon(1e-4));
  }
}
