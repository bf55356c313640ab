// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "edgefusion/manoeuvre.hpp"
#include "edgefusion/navigation_function.hpp"
#include "refusal.hpp"
#include "sweeps.hpp"

using namespace edgefusion;

namespace {

struct Scene {
  ObstacleMap map{0.05};
  NavigationFunction function{{0.2, 0.7, 4.0}};

  explicit Scene(double x = 0, double y = 0) {
    map.cover(x, y, x, y);
    see(map, x, y, 4);
    function.begin(map, x, y, 0.05, x, y);
    function.advance(map, 1'000'000);
  }
  const Potential& potential() const { return function.potential(); }
};

ManoeuvreTarget to(const Pose& pose) {
  return {0.0, true, pose, 0.05, 0.1};
}

std::vector<Leg> searched(const Scene& scene, const Pose& start, const ManoeuvreTarget& target,
                          const std::vector<double>& others = {}, double margin = 0.02) {
  Manoeuvre manoeuvre(pioneer());
  manoeuvre.begin(scene.map, scene.potential(), start, margin, target, others.data(), others.size() / 2);
  while (!manoeuvre.advance(scene.map, scene.potential(), 1000)) REQUIRE(manoeuvre.running());
  return manoeuvre.legs();
}

}  // namespace

TEST_CASE("straight ahead is one leg, anywhere on the map") {
  for (const double at : {0.0, -37.3, 9e4}) {
    const std::vector<Leg> legs = searched(Scene(at, -at), {at, -at, 0}, to({at + 0.8, -at, 0}));
    REQUIRE(legs.size() == 1);
    CHECK(legs[0].way == doctest::Approx(0.8).epsilon(0.07));
    CHECK(legs[0].turn == 0.0);
  }
}

TEST_CASE("headings of many turns are the same as of none") {
  const Scene scene;
  for (const double turns : {-1000.0, -1.0, 1.0, 7.0})
    CHECK(searched(scene, {0, 0, turns * 2 * std::acos(-1.0)}, to({0.8, 0, 0})).size() == 1);
}

TEST_CASE("others on the borders of bins, at the rim of the search and far beyond it") {
  const Scene scene;
  std::vector<double> others;
  for (int i = -20; i <= 20; ++i)
    for (const double y : {-0.4, 0.4, 2.4, -1e300, 1e12}) others.insert(others.end(), {i * 0.2, y});
  CHECK(searched(scene, {0, 0, 0}, to({0.8, 0, 0}), others).size() == 1);
  CHECK(searched(scene, {0, 0, 0}, to({0, 0.9, 0}), others).empty());
}

TEST_CASE("a target beyond the search, or on unseen ground, ends without legs") {
  const Scene scene;
  CHECK(searched(scene, {0, 0, 0}, to({1e12, 0, 0})).empty());
  ObstacleMap unseen(0.05);
  unseen.cover(0, 0, 0, 0);
  Manoeuvre manoeuvre(pioneer());
  manoeuvre.begin(unseen, scene.potential(), {0, 0, 0}, 0.02, to({0.8, 0, 0}), nullptr, 0);
  CHECK(manoeuvre.advance(unseen, scene.potential(), 1'000'000));
  CHECK(manoeuvre.legs().empty());
}

TEST_CASE("a start on no map, and what makes no search") {
  const Scene scene;
  CHECK(searched(scene, {1e9, 0, 0}, to({1e9 + 0.8, 0, 0})).empty());
  for (const double bad : {double(NAN), double(INFINITY)}) {
    CHECK_FALSE(refusal([&] { searched(scene, {bad, 0, 0}, to({0.8, 0, 0})); }).empty());
    CHECK_FALSE(refusal([&] { searched(scene, {0, 0, 0}, to({bad, 0, 0})); }).empty());
    CHECK_FALSE(refusal([&] { searched(scene, {0, 0, 0}, to({1, 0, 0}), {bad, 0}); }).empty());
    CHECK_FALSE(refusal([&] { searched(scene, {0, 0, 0}, to({1, 0, 0}), {}, bad); }).empty());
  }
}
