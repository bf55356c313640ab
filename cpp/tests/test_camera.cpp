// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "edgefusion/camera.hpp"

using namespace edgefusion;

namespace {

Eigen::Matrix3d intrinsics() {
  Eigen::Matrix3d K;
  K << 500, 0, 320, 0, 400, 240, 0, 0, 1;
  return K;
}

}  // namespace

TEST_CASE("a pinhole puts a point at f X / Z + c") {
  Eigen::Vector2d pixel;
  REQUIRE(Camera(intrinsics(), {}).project({0.5, -0.25, 2.0}, pixel) == Mark::kVisible);
  CHECK(pixel.x() == doctest::Approx(500 * 0.25 + 320));
  CHECK(pixel.y() == doctest::Approx(400 * -0.125 + 240));
}

TEST_CASE("a point on or behind the camera's plane is marked and has no pixel") {
  const Camera camera(intrinsics(), {});
  Eigen::Vector2d pixel;
  CHECK(camera.project({0.1, 0.0, 0.0}, pixel) == Mark::kBehind);
  CHECK(camera.project({0.1, 0.0, -1.0}, pixel) == Mark::kBehind);
  CHECK(std::isnan(pixel.x()));
}

TEST_CASE("without distortion everything in front is visible, however far off axis") {
  const Camera camera(intrinsics(), {0, 0, 0, 0, 0});
  Eigen::Vector2d pixel;
  CHECK(std::isinf(camera.max_radius()));
  CHECK(camera.project({1e6, 0.0, 1e-3}, pixel) == Mark::kVisible);
}

TEST_CASE("barrel distortion stops growing at sqrt(-1 / (3 k1)), and beyond it nothing is projected") {
  // The wall of PAPER.md: 61 degrees off axis, k1 = -0.3, would land in the middle of the picture.
  const Camera camera(intrinsics(), {-0.3, 0, 0, 0});
  CHECK(camera.max_radius() == doctest::Approx(std::sqrt(1 / 0.9)));
  const double off_axis = std::tan(61.0 * M_PI / 180.0);
  Eigen::Vector2d pixel;
  CHECK(camera.project({off_axis, 0.0, 1.0}, pixel) == Mark::kBeyond);
  CHECK(camera.project({0.99 * camera.max_radius(), 0.0, 1.0}, pixel) == Mark::kVisible);
}

TEST_CASE("a pole of the rational model ends the valid region too") {
  // N / D with D = 1 - u: the radius runs to infinity at u = 1 without ever shrinking.
  const Camera camera(intrinsics(), {0, 0, 0, 0, 0, -1.0, 0, 0});
  CHECK(camera.max_radius() == doctest::Approx(1.0));
}

TEST_CASE("a pixel that overflows is beyond, and has no value") {
  Eigen::Vector2d pixel;
  CHECK(Camera(intrinsics(), {}).project({1.0, 0.0, 1e-60}, pixel) == Mark::kBeyond);
  CHECK(std::isnan(pixel.x()));
  CHECK(Camera(intrinsics(), {}).project({1.0, 0.0, 1e-320}, pixel) == Mark::kBeyond);
}

TEST_CASE("where the tangential terms fold the picture back, nothing is projected") {
  // Along -x: x' = -r + 3 p2 r^2, which stops at r = 1 / (6 p2). The radial terms alone would grow for ever.
  const Camera camera(intrinsics(), {0, 0, 0, 0.05});
  const double turn = 1 / 0.3;
  Eigen::Vector2d pixel;
  CHECK(std::isinf(camera.max_radius()));
  CHECK(camera.project({-0.999 * turn, 0.0, 1.0}, pixel) == Mark::kVisible);
  CHECK(camera.project({-1.001 * turn, 0.0, 1.0}, pixel) == Mark::kBeyond);
  CHECK(std::isnan(pixel.x()));
  CHECK(camera.project({1.001 * turn, 0.0, 1.0}, pixel) == Mark::kVisible);  // on the other side it grows
}

TEST_CASE("nothing is projected onto a tilted sensor from behind it") {
  const double tilt = 0.5;
  const Camera camera(intrinsics(), {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, tilt});
  const double edge = 1 / std::tan(tilt);
  Eigen::Vector2d pixel;
  for (const double side : {-1.0, 1.0}) {
    const bool before = camera.project({side * 0.99 * edge, 0.0, 1.0}, pixel) == Mark::kVisible &&
                        camera.project({side * 1.01 * edge, 0.0, 1.0}, pixel) == Mark::kVisible;
    CHECK(before == (side > 0));
  }
}

TEST_CASE("what is no camera is refused") {
  Eigen::Matrix3d mirrored = intrinsics(), skewed = intrinsics(), unknown = intrinsics();
  mirrored(0, 0) = -500;
  skewed(0, 1) = 0.1;
  unknown(0, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(Camera(mirrored, {}), std::invalid_argument);
  CHECK_THROWS_AS(Camera(skewed, {}), std::invalid_argument);
  CHECK_THROWS_AS(Camera(unknown, {}), std::invalid_argument);
  CHECK_THROWS_AS(Camera(intrinsics(), {0.1, 0.2, 0.3}), std::invalid_argument);
  CHECK_THROWS_AS(Camera(intrinsics(), {0.1, NAN, 0, 0}), std::invalid_argument);
}
