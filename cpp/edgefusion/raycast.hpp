// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>

namespace edgefusion {

/// What a beam hits that meets no segment within its range.
constexpr std::int32_t kNoHit = -1;

/// Where the laser stands in the world [m, rad].
struct LaserPose {
  double x, y, theta;
};

/// Beam i points to angle_min + i * angle_increment in the laser's frame, over any part of a turn or several.
struct Sweep {
  double angle_min, angle_increment;  ///< the latter of either sign
  std::size_t n;
  double range_max;
};

/// What an ideal 2D laser measures among the walls of a world: exact ranges, without noise.
///
/// Each segment is tried only against the beams between its two ends: time is proportional to the number of
/// segments, and of beams that each is met by. Ends belong to a segment, so no beam passes between two
/// segments that share one; where two are equally near, the lower row is hit. A segment without length is hit
/// by no beam, one that lies along a beam at its nearer end, one that the laser stands on at 0.
///
/// segments  m x 4, row major: (x0, y0, x1, y1) in the world [m]
/// ranges    sweep.n values, written: metres, +infinity where nothing is within range_max
/// hits      sweep.n values, written: the row of the segment, or kNoHit
///
/// Throws std::invalid_argument for a coordinate, pose or angle that is not finite, an angle_increment of 0
/// and a range_max that is not finite and above 0.
void raycast(const double* segments, std::size_t m, const LaserPose& pose, const Sweep& sweep, double* ranges,
             std::int32_t* hits);

}  // namespace edgefusion
