// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "edgefusion/boxes.hpp"
#include "edgefusion/refuse.hpp"
#include "refusal.hpp"

using namespace edgefusion;

namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kStep = 0.5 * M_PI / 180.0;
const ToGround kLevel(0, 0, -0.3);

Camera camera() {
  Eigen::Matrix3d K;
  K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  return Camera(K, {});
}

Eigen::Matrix4d camera_at_laser() {
  Eigen::Matrix4d T;
  T << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 1;
  return T;
}

BoxRule rule(std::vector<double> heights) {
  return {std::move(heights), false, 0.0, true, 0.25};
}

struct Cluster {
  std::vector<double> ranges, angles;

  Beams beams() const { return {ranges.data(), angles.data(), ranges.size(), kStep}; }
};

// A flat face across the view, `x` metres ahead, from angle `first` in steps.
Cluster face(double x, double first, int n) {
  Cluster cluster;
  for (int i = 0; i < n; ++i) {
    const double angle = first + i * kStep;
    cluster.angles.push_back(angle);
    cluster.ranges.push_back(x / std::cos(angle));
  }
  return cluster;
}

std::vector<Box> boxes_of(const Cluster& cluster, const BoxRule& r, const ToGround& ground = kLevel) {
  std::vector<Box> boxes(r.heights.size());
  std::vector<std::int32_t> indices(r.heights.size());
  boxes.resize(candidate_boxes(cluster.beams(), camera(), camera_at_laser(), ground, kWidth, kHeight, r,
                               boxes.data(), indices.data()));
  return boxes;
}

}  // namespace

TEST_CASE("a box is as wide as the beams and half a beam more on either side, and stands on the ground") {
  const Cluster cluster = face(2.0, -10 * kStep, 21);
  const std::vector<Box> boxes = boxes_of(cluster, rule({1.0}));
  REQUIRE(boxes.size() == 1);
  const double half = 500 * std::tan(10.5 * kStep);
  CHECK(std::abs(boxes[0].x0 - (320.5 - half)) <= 1.0);
  CHECK(std::abs(boxes[0].x1 - (320.5 + half)) <= 1.0);
  CHECK(boxes[0].y1 == std::lround(240.5 + 500 * 0.3 / 2.0));
  CHECK(std::abs(boxes[0].height() - boxes[0].width()) <= 1);
}

TEST_CASE("each box is wider than the last by the step, its height is its own width times the ratio") {
  BoxRule wider = rule({0.5, 0.5, 0.5});
  wider.width_step = 0.2;
  const std::vector<Box> boxes = boxes_of(face(3.0, -8 * kStep, 17), wider);
  REQUIRE(boxes.size() == 3);
  CHECK(std::abs(boxes[1].width() - 1.2 * boxes[0].width()) <= 2);
  CHECK(std::abs(boxes[2].width() - 1.4 * boxes[0].width()) <= 2);
  CHECK(std::abs(boxes[2].height() - 0.5 * boxes[2].width()) <= 1);
}

TEST_CASE("metric heights are metres above the ground at the nearest beam") {
  BoxRule metric = rule({0.3, 0.6});
  metric.heights_are_metric = true;
  const std::vector<Box> boxes = boxes_of(face(2.0, -10 * kStep, 21), metric);
  REQUIRE(boxes.size() == 2);
  CHECK(boxes[0].height() == 75);  // 500 px * 0.3 m / 2 m: up to the scan plane
  CHECK(boxes[1].height() == 150);
}

TEST_CASE("on the scan line the box begins where the laser hits") {
  BoxRule scan_line = rule({0.5});
  scan_line.on_ground = false;
  const std::vector<Box> boxes = boxes_of(face(2.0, -10 * kStep, 21), scan_line);
  REQUIRE(boxes.size() == 1);
  CHECK(std::abs(boxes[0].y1 - 240) <= 1);
}

TEST_CASE("a laser mounted upside down stands on the same ground") {
  // Upside down, y and z point the other way: the beams come mirrored, the ground is along +z.
  Eigen::Matrix4d flip = Eigen::Matrix4d::Identity();
  flip(1, 1) = flip(2, 2) = -1;
  const Cluster cluster = face(2.0, 4 * kStep, 11);
  Cluster mirrored = cluster;
  for (double& angle : mirrored.angles) angle = -angle;
  const BoxRule r = rule({1.0});
  Box upright{}, flipped{};
  std::int32_t index = 0;
  REQUIRE(candidate_boxes(cluster.beams(), camera(), camera_at_laser(), kLevel, kWidth, kHeight, r, &upright,
                          &index) == 1);
  REQUIRE(candidate_boxes(mirrored.beams(), camera(), camera_at_laser() * flip, -kLevel, kWidth, kHeight, r,
                          &flipped, &index) == 1);
  CHECK(upright.x0 == flipped.x0);
  CHECK(upright.y1 == flipped.y1);
  CHECK(upright.x1 == flipped.x1);
}

TEST_CASE("a box stays inside the image, and one that leaves too little of itself there is dropped") {
  const Cluster at_edge = face(2.0, 58 * kStep, 12);  // its left part is outside
  const std::vector<Box> kept = boxes_of(at_edge, rule({1.0}));
  for (const Box& box : kept) {
    CHECK(box.x0 >= 0);
    CHECK(box.y0 >= 0);
    CHECK(box.x1 <= kWidth);
    CHECK(box.y1 <= kHeight);
  }
  REQUIRE(kept.size() == 1);
  BoxRule strict = rule({1.0});
  strict.min_visible = 0.95;
  CHECK(boxes_of(at_edge, strict).empty());
}

TEST_CASE("what the camera cannot see has no boxes") {
  CHECK(boxes_of(face(2.0, 70 * kStep, 10), rule({1.0})).empty());  // beside the image
  Cluster behind;
  behind.angles = {M_PI - kStep, M_PI, M_PI + kStep};
  behind.ranges = {1.0, 1.0, 1.0};
  CHECK(boxes_of(behind, rule({1.0})).empty());
  CHECK(boxes_of(Cluster{}, rule({1.0})).empty());
}

TEST_CASE("geometry never raises: ranges of any size give boxes inside the image or none") {
  for (const double range : {1e-9, 1e-3, 0.05, 1.0, 1e3, 1e9, 1e300}) {
    Cluster cluster = face(1.0, -60 * kStep, 121);
    for (double& r : cluster.ranges) r = range;
    const std::vector<Box> boxes = boxes_of(cluster, rule({0.1, 1.0, 50.0}));
    if (range == 1.0) CHECK(!boxes.empty());
    for (const Box& box : boxes) {
      CHECK(box.width() >= 1);
      CHECK(box.height() >= 1);
      CHECK(box.x0 >= 0);
      CHECK(box.x1 <= kWidth);
      CHECK(box.y0 >= 0);
      CHECK(box.y1 <= kHeight);
    }
  }
}

TEST_CASE("a way to the ground of any length gives the same metric heights on the scan line") {
  BoxRule metric = rule({0.3});
  metric.heights_are_metric = true;
  metric.on_ground = false;
  for (const double length : {1e-300, 1.0, 1e300}) {
    const std::vector<Box> boxes = boxes_of(face(2.0, -10 * kStep, 21), metric, ToGround(0, 0, -length));
    REQUIRE(boxes.size() == 1);
    CHECK(boxes[0].height() == 75);
  }
}

TEST_CASE("what is no cluster, no rule or no scene is refused by name") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto message = [](const Cluster& cluster, double step, const Eigen::Matrix4d& T,
                          const ToGround& ground, int width, int height, const BoxRule& r) {
    return refusal([&] {
      std::vector<Box> boxes(r.heights.size());
      std::vector<std::int32_t> indices(r.heights.size());
      const Beams beams{cluster.ranges.data(), cluster.angles.data(), cluster.ranges.size(), step};
      candidate_boxes(beams, camera(), T, ground, width, height, r, boxes.data(), indices.data());
    });
  };
  const Cluster good = face(2.0, 0, 3);
  const Eigen::Matrix4d T = camera_at_laser();
  const BoxRule r = rule({1.0});
  CHECK(message(good, kStep, T, kLevel, 9, 9, r) == "");

  for (const double value : {nan, inf, -inf}) {
    Cluster ranges = good, angles = good;
    ranges.ranges[2] = angles.angles[1] = value;
    CHECK(message(ranges, kStep, T, kLevel, 9, 9, r).find("ranges_m: expected finite numbers, got ") == 0);
    CHECK(message(ranges, kStep, T, kLevel, 9, 9, r).find(" at index 2") != std::string::npos);
    CHECK(message(angles, kStep, T, kLevel, 9, 9, r).find("angles_rad: expected finite") == 0);
    CHECK(message(good, kStep, T, {0, value, -1}, 9, 9, r).find("to_ground: expected finite") == 0);
  }
  for (const double step : {0.0, -0.1, nan, inf})
    CHECK(message(good, step, T, kLevel, 9, 9, r).find("step_rad: expected") == 0);
  CHECK(message(good, kStep, T, {0, 0, 0}, 9, 9, r).find("to_ground: expected") == 0);
  CHECK(message(good, kStep, T, kLevel, 0, 9, r) == "width: expected at least 1, got 0");
  CHECK(message(good, kStep, T, kLevel, 9, -1, r) == "height: expected at least 1, got -1");
  CHECK(message(good, kStep, 2 * T, kLevel, 9, 9, r) ==
        "T_camera_laser: expected [0, 0, 0, 1] as last row, got [0, 0, 0, 2]");

  CHECK(message(good, kStep, T, kLevel, 9, 9, rule({})) == "heights: expected at least one, got none");
  for (const double height : {0.0, -1.0, nan, inf})
    CHECK(message(good, kStep, T, kLevel, 9, 9, rule({1.0, height})).find("heights: expected") == 0);
  for (const double step : {-0.1, nan, inf}) {
    BoxRule wrong = r;
    wrong.width_step = step;
    CHECK(message(good, kStep, T, kLevel, 9, 9, wrong).find("width_step: expected") == 0);
  }
  for (const double share : {0.0, -1.0, 1.0000001, nan}) {
    BoxRule wrong = r;
    wrong.min_visible = share;
    CHECK(message(good, kStep, T, kLevel, 9, 9, wrong) ==
          "min_visible: expected above 0 and at most 1, got " + shown(share));
  }
}
