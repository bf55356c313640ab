// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// What navigation's tests and benchmarks put on a map.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "edgefusion/obstacle_map.hpp"

namespace edgefusion {

/// One scan from one pose.
inline void insert(ObstacleMap& map, const Pose& pose, const std::vector<float>& ranges,
                   double angle_min = 0.0, double angle_increment = 0.01, double range_max = 20.0) {
  std::vector<double> poses;
  for (std::size_t i = 0; i < ranges.size(); ++i) poses.insert(poses.end(), {pose.x, pose.y, pose.theta});
  map.insert({poses.data(), ranges.data(), ranges.size(), angle_min, angle_increment, 0.0, range_max}, 0);
}

/// A point, seen often enough to shut ways, by a laser so near that its beam comes through nothing.
inline void put(ObstacleMap& map, double x, double y) {
  for (int i = 0; i < 2; ++i) insert(map, {x - 0.0625, y, 0.0}, {0.0625f});
}

/// Makes the ground about (x, y) known and free.
inline void see(ObstacleMap& map, double x, double y, double radius) {
  const std::vector<float> beams(2000, std::numeric_limits<float>::infinity());
  insert(map, {x, y, 0.0}, beams, 0.0, 2.0 * std::acos(-1.0) / 2000.0, radius);
}

inline Footprint pioneer() {
  const double corners[] = {0.210, 0.2125, -0.301, 0.2125, -0.301, -0.2125, 0.210, -0.2125};
  return Footprint(corners, 4);
}

}  // namespace edgefusion
