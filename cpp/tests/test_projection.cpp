// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "edgefusion/projection.hpp"
#include "refusal.hpp"

using namespace edgefusion;

namespace {

Eigen::Matrix3d centred_intrinsics() {
  Eigen::Matrix3d K;
  K << 500, 0, 320, 0, 500, 240, 0, 0, 1;  // of a 640 x 480 image
  return K;
}

// Robot axes (x forward, y left, z up) into camera axes (z forward, x right, y down).
Eigen::Matrix4d camera_at_laser() {
  Eigen::Matrix4d T;
  T << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 1;
  return T;
}

}  // namespace

TEST_CASE("a point ahead and to the left lands left of the centre, one above it higher up") {
  const std::array<double, 6> points{2, 0.5, 0, 2, 0, 0.5};
  std::array<double, 4> pixels{};
  std::array<std::uint8_t, 2> marks{};
  project(points.data(), 2, Camera(centred_intrinsics(), {}), camera_at_laser(), pixels.data(), marks.data());
  CHECK(pixels[0] == doctest::Approx(320 - 125));
  CHECK(pixels[1] == doctest::Approx(240));
  CHECK(pixels[2] == doctest::Approx(320));
  CHECK(pixels[3] == doctest::Approx(240 - 125));
  CHECK(marks[0] == static_cast<std::uint8_t>(Mark::kVisible));
}

TEST_CASE("eqs. (2) and (3) agree with eq. (1) for a centred principal point") {
  const std::array<double, 6> points{3, 1, -0.4, 1.5, -0.7, 0.2};
  std::array<double, 4> pixels{}, paper{};
  std::array<std::uint8_t, 2> marks{};
  project(points.data(), 2, Camera(centred_intrinsics(), {}), camera_at_laser(), pixels.data(), marks.data());
  project_paper(points.data(), 2, centred_intrinsics(), 640, 480, paper.data());
  for (std::size_t i = 0; i < 4; ++i) CHECK(paper[i] == doctest::Approx(pixels[i]));
}

TEST_CASE("a point behind the camera has no pixel by either form") {
  const std::array<double, 3> behind{-2, 0.5, 0};
  std::array<double, 2> pixels{}, paper{};
  std::array<std::uint8_t, 1> marks{};
  project(behind.data(), 1, Camera(centred_intrinsics(), {}), camera_at_laser(), pixels.data(), marks.data());
  project_paper(behind.data(), 1, centred_intrinsics(), 640, 480, paper.data());
  CHECK(marks[0] == static_cast<std::uint8_t>(Mark::kBehind));
  CHECK(std::isnan(pixels[0]));
  CHECK(std::isnan(paper[0]));
}

TEST_CASE("a point that is not finite is refused by its row, a matrix that moves nothing rigidly by name") {
  const Camera camera(centred_intrinsics(), {});
  std::array<double, 4> pixels{};
  std::array<std::uint8_t, 2> marks{};
  const auto message = [&](const std::array<double, 6>& points, const Eigen::Matrix4d& T) {
    return refusal([&] { project(points.data(), 2, camera, T, pixels.data(), marks.data()); });
  };
  const auto paper = [&](const std::array<double, 6>& points, const Eigen::Matrix3d& K) {
    return refusal([&] { project_paper(points.data(), 2, K, 640, 480, pixels.data()); });
  };
  const std::array<double, 6> good{1, 2, 3, 4, 5, 6}, bad{1, 2, 3, 4, NAN, 6};
  Eigen::Matrix4d unknown = camera_at_laser(), shrunk = camera_at_laser();
  unknown(1, 3) = INFINITY;
  shrunk(3, 3) = 0.5;
  CHECK(message(good, camera_at_laser()) == "");
  CHECK(message(bad, camera_at_laser()) == "points: expected finite coordinates, got (4, nan, 6) in row 1");
  CHECK(message(good, unknown) == "T_camera_laser: expected finite numbers");
  CHECK(message(good, shrunk) == "T_camera_laser: expected [0, 0, 0, 1] as last row, got [0, 0, 0, 0.5]");
  CHECK(paper(good, centred_intrinsics()) == "");
  CHECK(paper(bad, centred_intrinsics()) == "points: expected finite coordinates, got (4, nan, 6) in row 1");
  CHECK(paper(good, -centred_intrinsics()).find("K: expected focal lengths above 0, got -500") == 0);
}
