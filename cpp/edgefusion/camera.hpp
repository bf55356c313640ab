// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace edgefusion {

/// What became of a projected point.
enum class Mark : std::uint8_t {
  kVisible = 0,  ///< in front of the camera; its pixel may still lie outside the image
  kBehind = 1,   ///< on or behind the camera's plane
  kBeyond = 2,   ///< so far off axis that the distortion folds back, or overflows: no pixel is right
};

/// Throws std::invalid_argument for a K that is not finite or no intrinsic matrix [px].
void check_intrinsics(const Eigen::Matrix3d& K);

/// OpenCV's camera: pinhole, then radial, tangential, thin prism and tilt distortion
/// (k1, k2, p1, p2[, k3[, k4, k5, k6[, s1, s2, s3, s4[, tau_x, tau_y]]]]; or no coefficients at all).
class Camera {
 public:
  /// K: intrinsic matrix [px]. Throws std::invalid_argument for a K that is no intrinsic matrix, a value that
  /// is not finite, or a count of coefficients other than 0, 4, 5, 8, 12 or 14.
  Camera(const Eigen::Matrix3d& K, const std::vector<double>& distortion);

  /// Pixel of a point of the camera's frame (z forward, x right, y down) [m]; NaN unless kVisible.
  ///
  /// kBeyond are points outside max_radius(), which knows the radial coefficients only, and those where all
  /// coefficients together turn the picture over: where the determinant of the distortion's derivative is not
  /// positive.
  Mark project(const Eigen::Vector3d& point, Eigen::Vector2d& pixel) const;

  /// Tangent of the angle off axis up to which the distorted radius grows by its radial coefficients; may be
  /// infinite.
  double max_radius() const { return max_radius_; }

 private:
  Eigen::Vector3d distort(const Eigen::Vector2d& undistorted) const;  // homogeneous
  bool keeps_orientation(const Eigen::Vector2d& undistorted) const;

  Eigen::Matrix3d K_;
  std::array<double, 14> k_;  // absent coefficients are 0
  Eigen::Matrix3d tilt_;
  double max_radius_;
};

}  // namespace edgefusion
