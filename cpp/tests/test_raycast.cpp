// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "edgefusion/raycast.hpp"
#include "refusal.hpp"

using namespace edgefusion;

namespace {

const double kPi = std::acos(-1.0);
const double kInfinity = std::numeric_limits<double>::infinity();

struct Ranges {
  std::vector<double> ranges;
  std::vector<std::int32_t> hits;

  bool operator==(const Ranges& other) const { return ranges == other.ranges && hits == other.hits; }
};

Ranges cast(const std::vector<double>& segments, const LaserPose& pose, const Sweep& sweep) {
  Ranges out{std::vector<double>(sweep.n), std::vector<std::int32_t>(sweep.n)};
  raycast(segments.data(), segments.size() / 4, pose, sweep, out.ranges.data(), out.hits.data());
  return out;
}

// One beam alone, and one segment at a time: nothing is left out because of where it lies.
Ranges one_by_one(const std::vector<double>& segments, const LaserPose& pose, const Sweep& sweep) {
  Ranges nearest{std::vector<double>(sweep.n, kInfinity), std::vector<std::int32_t>(sweep.n, kNoHit)};
  for (std::size_t i = 0; i < sweep.n; ++i)
    for (std::size_t row = 0; row < segments.size() / 4; ++row) {
      const double angle = sweep.angle_min + static_cast<double>(i) * sweep.angle_increment;
      const std::vector<double> segment(segments.begin() + 4 * row, segments.begin() + 4 * row + 4);
      const Ranges one = cast(segment, pose, {angle, 1.0, 1, sweep.range_max});
      if (one.ranges[0] < nearest.ranges[i]) {
        nearest.ranges[i] = one.ranges[0];
        nearest.hits[i] = static_cast<std::int32_t>(row);
      }
    }
  return nearest;
}

const std::vector<double> kWall{2, -1, 2, 1};

}  // namespace

TEST_CASE("a wall ahead is hit between its ends, at the range of its plane") {
  const Ranges out = cast(kWall, {0, 0, 0}, {-kPi / 2, kPi / 360, 361, 10});
  for (int i = 0; i <= 360; ++i) {
    const double angle = (i - 180) * kPi / 360;
    const bool hit = std::abs(2 * std::tan(angle)) <= 1;
    CAPTURE(i);
    CHECK(out.hits[i] == (hit ? 0 : kNoHit));
    if (hit)
      CHECK(out.ranges[i] == doctest::Approx(2 / std::cos(angle)));
    else
      CHECK(out.ranges[i] == kInfinity);
  }
}

TEST_CASE("the laser's pose moves and turns the beams") {
  const Ranges out = cast(kWall, {2.5, 0.5, kPi}, {0.0, 0.1, 1, 10});
  CHECK(out.ranges[0] == doctest::Approx(0.5));
  CHECK(cast(kWall, {2.5, 0.5, 0.0}, {0.0, 0.1, 1, 10}).hits[0] == kNoHit);
}

TEST_CASE("of several segments the nearest is hit, of two that are equally near the lower row") {
  const std::vector<double> walls{3, -1, 3, 1, 2, -1, 2, 1, 2, 1, 2, -1};
  const Ranges out = cast(walls, {0, 0, 0}, {0, 0.1, 1, 10});
  CHECK(out.ranges[0] == doctest::Approx(2.0));
  CHECK(out.hits[0] == 1);
}

TEST_CASE("range_max is inclusive") {
  CHECK(cast(kWall, {0, 0, 0}, {0, 0.1, 1, 2.0}).ranges[0] == 2.0);
  CHECK(cast(kWall, {0, 0, 0}, {0, 0.1, 1, 1.999}).ranges[0] == kInfinity);
}

TEST_CASE("no beam slips through a corner that two segments share") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-3, 3), angle(-kPi, kPi);
  for (int trial = 0; trial < 2000; ++trial) {
    const LaserPose pose{coordinate(random), coordinate(random), angle(random)};
    const double at = angle(random), r = 1 + std::abs(coordinate(random));
    const auto x = [&](double a) { return pose.x + r * std::cos(a); };
    const auto y = [&](double a) { return pose.y + r * std::sin(a); };
    const double left = at + 0.3, right = at - 0.4;
    const std::vector<double> corner{x(left), y(left), x(at), y(at), x(at), y(at), x(right), y(right)};
    const Ranges out = cast(corner, pose, {at - pose.theta, 0.1, 1, 100});
    CHECK(out.ranges[0] == doctest::Approx(r));
  }
}

TEST_CASE("a segment without length is hit by nobody, one along the beam at its nearer end") {
  CHECK(cast({2, 0, 2, 0}, {0, 0, 0}, {0, 0.1, 1, 10}).hits[0] == kNoHit);
  CHECK(cast({3, 0, 2, 0}, {0, 0, 0}, {0, 0.1, 1, 10}).ranges[0] == 2.0);
  CHECK(cast({-3, 0, -2, 0}, {0, 0, 0}, {0, 0.1, 1, 10}).hits[0] == kNoHit);
}

TEST_CASE("a laser that stands on a segment, on its end or in its line reads what is there") {
  const Sweep turn{0.1, 0.5, 13, 10};
  for (const double range : cast({-1, 0, 1, 0}, {0, 0, 0}, turn).ranges) CHECK(range == 0.0);
  for (const double range : cast({0, 0, 1, 0}, {0, 0, 0}, turn).ranges) CHECK(range == 0.0);
  for (const double range : cast({1, 0, 0, 0}, {0, 0, 0}, turn).ranges) CHECK(range == 0.0);
  for (const double range : cast({1, 0, 2, 0}, {0, 0, 0}, turn).ranges) CHECK(range == kInfinity);
}

TEST_CASE("any sweep of any world equals beam by beam and segment by segment") {
  std::mt19937 random(9);
  std::uniform_int_distribution<int> eighth(-40, 40), beams(0, 60);
  std::uniform_real_distribution<double> angle(-8, 8), step(-2, 2);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> segments(4 * (trial % 20));
    for (double& value : segments) value = eighth(random) / 8.0;
    const LaserPose pose{eighth(random) / 8.0, eighth(random) / 8.0, angle(random)};
    const double increment = trial % 3 ? step(random) : kPi / 8;
    const Sweep sweep{angle(random), increment, static_cast<std::size_t>(beams(random)), 6.0};
    CAPTURE(trial);
    CHECK(cast(segments, pose, sweep) == one_by_one(segments, pose, sweep));
  }
}

TEST_CASE("numbers that make no sweep are refused by name") {
  const auto message = [](const std::vector<double>& segments, const LaserPose& pose, const Sweep& sweep) {
    return refusal([&] { cast(segments, pose, sweep); });
  };
  const LaserPose pose{0, 0, 0};
  const Sweep sweep{0, 0.1, 3, 10};
  CHECK(message({0, 0, 1, 1, 0, NAN, 1, 1}, pose, sweep) ==
        "segments: expected finite numbers, got nan at index 5");
  CHECK(message(kWall, {0, INFINITY, 0}, sweep) == "pose: expected finite numbers, got inf at index 1");
  CHECK(message(kWall, pose, {NAN, 0.1, 3, 10}) == "angle_min: expected a finite number, got nan");
  CHECK(message(kWall, pose, {0, 0, 3, 10}) ==
        "angle_increment: expected a finite number other than 0, got 0");
  CHECK(message(kWall, pose, {0, 1e308, 3, 10}) ==
        "angle_increment: expected finite angles of all beams, got inf");
  for (const double range_max : {0.0, -1.0, double(NAN), double(INFINITY)})
    CHECK(message(kWall, pose, {0, 0.1, 3, range_max}).find("range_max: expected a finite number above 0") ==
          0);
}
