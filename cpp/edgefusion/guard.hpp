// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <vector>

#include "edgefusion/footprint.hpp"
#include "edgefusion/obstacle_map.hpp"

namespace edgefusion {

/// A pose, and how fast the base is there [m/s, rad/s].
struct Motion {
  Pose pose;
  double v, w;
};

/// A velocity to reach and keep [m/s, rad/s].
struct Command {
  double v, w;
};

/// How fast the drive reaches a commanded velocity, and stops.
struct Ramps {
  double acceleration, yaw_acceleration;  ///< [m/s^2, rad/s^2]
};

/// Knows what is around the base now, and says which commands it can still be stopped after without touching it.
class Guard {
 public:
  /// Throws std::invalid_argument for ramps that are not finite and above 0.
  Guard(const Footprint& footprint, const Ramps& ramps);

  /// What there is: the map's points within `reach` of the base, and others that move.
  ///
  /// moving  k x 4, row major: (x, y, vx, vy) in the map, now
  ///
  /// Throws std::invalid_argument for numbers that are not finite.
  void look(const ObstacleMap& map, double x, double y, double reach, const double* moving, std::size_t k);

  /// From the hull to the nearest point that does not move [m], infinity where there is none within reach.
  double gap(const Pose& pose) const;

  /// Whether a base that moves so can follow the command for `hold` seconds, then brake, and come no nearer than
  /// `margin` to anything meanwhile. A base that is nearer already may go where it does not come nearer still. It goes
  /// forward only where its nose, and back only where its tail, comes to ground that was seen.
  ///
  /// Throws std::invalid_argument for numbers that are not finite, a hold and a linger below 0.
  /// What moves must not come nearer for `linger` seconds after it stands, either.
  bool free(const ObstacleMap& map, const Motion& start, const Command& command, double hold, double margin,
            double linger) const;

  /// Whether anything moves.
  bool stirs() const { return moving_ > 0; }

  /// Whether the hull fits there, `margin` from all points; what moves is where it is now.
  bool fits(const Pose& pose, double margin) const;

 private:
  struct Point {
    double x, y, vx, vy;
  };
  struct Gaps {
    double standing, moving;
  };
  Gaps gaps(const Pose& pose, double after, double beyond) const;
  struct Needs {
    double least;                 // to be kept to every point ...
    std::vector<double> credits;  // ... whose gap counts for so much more
  };
  Needs needs(const Pose& start, double margin) const;
  bool keeps(const Pose& pose, double after, const Needs& needs) const;
  bool passed_by(const Pose& pose, double from, double linger, double margin) const;
  bool shown(const ObstacleMap& map, const Pose& pose, double ahead) const;

  Footprint footprint_;
  Ramps ramps_;
  std::vector<Point> points_;  // those that move last
  std::size_t moving_ = 0;
};

/// So deep things are taken to be behind what is seen of them, as far as the ground there was never seen [m]: a tail
/// that swings must not meet the far side of a post.
constexpr double kDepth = 0.15;

/// Points nearer than this share of the margin are judged each by itself: to those the base comes no nearer, and they
/// loosen nothing else. Points between that and the margin lower what is kept to all.
constexpr double kTooNear = 0.3;

/// What a base must keep to a point that is so near now: the margin, or, where it is nearer already, hardly less.
double kept(double gap, double margin);

/// Where a base gets to that follows a command for some time, from the velocity that it has.
///
/// Throws std::invalid_argument for ramps that are not finite and above 0, and a duration not finite or below 0.
Motion followed(const Motion& start, const Command& command, const Ramps& ramps, double duration);

}  // namespace edgefusion
