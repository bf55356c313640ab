// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace edgefusion {

/// What became of a projected point.
enum class Mark : std::uint8_t {
  kVisible = 0,  ///< in front of the camera; its pixel may still lie outside the image
  kBehind = 1,   ///< on or behind the camera's plane
  kBeyond = 2,   ///< so far off axis that the distortion folds back: its pixel would be a lie
};

/// OpenCV's camera: pinhole, then radial, tangential, thin prism and tilt distortion
/// (k1, k2, p1, p2[, k3[, k4, k5, k6[, s1, s2, s3, s4[, tau_x, tau_y]]]]; none is 0 coefficients).
class Camera {
 public:
  /// K: intrinsic matrix [px]. Throws std::invalid_argument for a K that is no intrinsic matrix, a value that is
  /// not finite, or a count of coefficients other than 0, 4, 5, 8, 12 or 14.
  Camera(const Eigen::Matrix3d& K, const std::vector<double>& distortion);

  /// Pixel of a point of the camera's frame (z forward, x right, y down) [m]; untouched unless kVisible.
  Mark project(const Eigen::Vector3d& point, Eigen::Vector2d& pixel) const;

  /// Undistorted radius (tangent of the angle off axis) up to which the distorted radius grows; may be infinite.
  double max_radius() const { return max_radius_; }

 private:
  Eigen::Vector2d distort(const Eigen::Vector2d& undistorted) const;

  Eigen::Matrix3d K_;
  std::vector<double> k_;  // 14 coefficients, absent ones 0
  Eigen::Matrix3d tilt_;
  double max_radius_;
};

/// Projects n points of the laser's frame: p ~ K R [I | -t] P, eq. (1), T_camera_laser = [R | -R t].
///
/// points  n x 3, row major [m]
/// pixels  n x 2, written; NaN where the mark is not kVisible
/// marks   n, written
void project(const double* points, std::size_t n, const Camera& camera, const Eigen::Matrix4d& T_camera_laser,
             double* pixels, std::uint8_t* marks);

/// The paper's eqs. (2) and (3): x = width - (Y fx / X + cx), y = height - (Z fy / X + cy), from points in robot
/// axes (X forward, Y left, Z up) with the camera as origin. It mirrors the principal point: right only where
/// cx = width / 2 and cy = height / 2. NaN where X <= 0.
void project_paper(const double* points, std::size_t n, const Eigen::Matrix3d& K, int width, int height,
                   double* pixels);

/// The distorted radius at an undistorted one grows up to here (OpenCV's radial polynomial); may be infinite.
double max_undistorted_radius(const std::vector<double>& distortion);

}  // namespace edgefusion
