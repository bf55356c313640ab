// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "edgefusion/box.hpp"
#include "edgefusion/camera.hpp"

namespace edgefusion {

/// The beams of one cluster, in the laser's frame.
struct Beams {
  const double* ranges_m;
  const double* angles_rad;
  std::size_t n;
  double step_rad;  ///< between neighbouring beams; each is taken half a step wide on either side
};

/// Which boxes to propose for a cluster of known pixel width and unknown height.
struct BoxRule {
  std::vector<double> heights;  ///< at least one, above 0, see heights_are_metric
  bool heights_are_metric;  ///< metres above the bottom edge, or else pixel height / pixel width of the box
  double width_step;   ///< box k is 1 + k * width_step times as wide as the cluster (paper: 0 or a little)
  bool on_ground;      ///< bottom edge on the ground under the nearest beam, or on the scan line
  double min_visible;  ///< share of a box's area that must be inside the image, above 0 and at most 1
};

/// Where the cluster stands in the world: the way from a laser point straight down to the ground, in the
/// laser's frame [m]. (0, 0, -h) for a level laser at height h, (0, 0, h) for one mounted upside down.
using ToGround = Eigen::Vector3d;

/// Candidate boxes of one cluster, clipped to the image.
///
/// boxes    up to rule.heights.size() boxes, written
/// indices  the height each box belongs to, written
///
/// Returns the number written. A box of which less than min_visible would remain is dropped, as is everything
/// of a cluster that the camera cannot see: wherever the cluster is, geometry never raises.
///
/// Throws std::invalid_argument for a range or an angle that is not finite, naming its index; a step_rad that
/// is not finite and above 0; a T_camera_laser that check_transform refuses; a to_ground that is not finite
/// or has no length; width or height below 1; and a rule that is not as BoxRule says.
std::size_t candidate_boxes(const Beams& beams, const Camera& camera, const Eigen::Matrix4d& T_camera_laser,
                            const ToGround& to_ground, int width, int height, const BoxRule& rule, Box* boxes,
                            std::int32_t* indices);

}  // namespace edgefusion
