// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/projection.hpp"

#include <cmath>
#include <limits>

#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

void check_points(const double* points, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double* p = points + 3 * i;
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
      refuse("points: expected finite coordinates, got (", p[0], ", ", p[1], ", ", p[2], ") in row ", i);
  }
}

}  // namespace

void check_transform(const char* name, const Eigen::Matrix4d& T) {
  if (!T.allFinite()) refuse(name, ": expected finite numbers");
  if (T.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    refuse(name, ": expected [0, 0, 0, 1] as last row, got [", T(3, 0), ", ", T(3, 1), ", ", T(3, 2), ", ",
           T(3, 3), "]");
}

void project(const double* points, std::size_t n, const Camera& camera, const Eigen::Matrix4d& T_camera_laser,
             double* pixels, std::uint8_t* marks) {
  check_points(points, n);
  check_transform("T_camera_laser", T_camera_laser);
  const Eigen::Matrix3d R = T_camera_laser.topLeftCorner<3, 3>();
  const Eigen::Vector3d translation = T_camera_laser.topRightCorner<3, 1>();  // -R t
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Map<const Eigen::Vector3d> P(points + 3 * i);
    Eigen::Vector2d pixel;
    marks[i] = static_cast<std::uint8_t>(camera.project(R * P + translation, pixel));
    Eigen::Map<Eigen::Vector2d>(pixels + 2 * i) = pixel;
  }
}

void project_paper(const double* points, std::size_t n, const Eigen::Matrix3d& K, int width, int height,
                   double* pixels) {
  check_points(points, n);
  check_intrinsics(K);
  const double fx = K(0, 0), fy = K(1, 1), cx = K(0, 2), cy = K(1, 2);
  for (std::size_t i = 0; i < n; ++i) {
    const double X = points[3 * i], Y = points[3 * i + 1], Z = points[3 * i + 2];
    const bool ahead = X > 0.0;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    pixels[2 * i] = ahead ? width - (Y * fx / X + cx) : nan;       // eq. (2)
    pixels[2 * i + 1] = ahead ? height - (Z * fy / X + cy) : nan;  // eq. (3)
  }
}

}  // namespace edgefusion
