// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "edgefusion/camera.hpp"

namespace edgefusion {

/// Throws std::invalid_argument unless the matrix is finite and its last row (0, 0, 0, 1).
void check_transform(const char* name, const Eigen::Matrix4d& T);

/// Projects n points of the laser's frame: p ~ K R [I | -t] P, eq. (1), T_camera_laser = [R | -R t].
///
/// points  n x 3, row major [m]
/// pixels  n x 2, written; NaN where the mark is not kVisible
/// marks   n values of Mark, written
///
/// Throws std::invalid_argument for a point that is not finite, naming its row, or a T_camera_laser that
/// check_transform refuses.
void project(const double* points, std::size_t n, const Camera& camera, const Eigen::Matrix4d& T_camera_laser,
             double* pixels, std::uint8_t* marks);

/// The paper's eqs. (2) and (3): x = width - (Y fx / X + cx), y = height - (Z fy / X + cy), from points in
/// robot axes (X forward, Y left, Z up) with the camera as origin. It mirrors the principal point: right only
/// where cx = width / 2 and cy = height / 2. NaN where X <= 0.
///
/// Throws std::invalid_argument for a point that is not finite, naming its row, or a K that check_intrinsics
/// refuses.
void project_paper(const double* points, std::size_t n, const Eigen::Matrix3d& K, int width, int height,
                   double* pixels);

}  // namespace edgefusion
