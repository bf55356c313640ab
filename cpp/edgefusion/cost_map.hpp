// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "edgefusion/obstacle_map.hpp"

namespace edgefusion {

/// How obstacles make ways longer.
struct WayCost {
  double blocked;  ///< the base's middle never comes nearer to a point than this [m]
  double comfort;  ///< from here on obstacles are of no account [m]; in between ways cost more
  double weight;   ///< a metre right beside what is blocked counts 1 + weight
};

/// What a metre costs in every cell of a map, by how far from its middle the nearest point is. It is computed in
/// portions, from what each row holds when its turn comes.
class CostMap {
 public:
  /// Throws std::invalid_argument for a cost that is not finite or below 0, and comfort not above blocked.
  explicit CostMap(const WayCost& cost);

  /// How often it goes over all cells until it is done.
  static constexpr std::size_t kSweeps = 2;

  /// Begins anew, for the map's window.
  void begin(const ObstacleMap& map);

  /// Works on some rows, until about so many cells are done; answers how many were. The map must have the window that
  /// it had at the beginning.
  std::size_t advance(const ObstacleMap& map, std::size_t cells);

  bool done() const { return stage_ == Stage::kDone; }

  /// What a metre costs there, once it is done; infinity where the base cannot be.
  float at(std::size_t index, std::int32_t column, std::int32_t row) const;

  /// As it was checked.
  const WayCost& cost() const { return cost_; }

 private:
  enum class Stage { kUpwards, kDownwards, kDone };
  struct Point {
    float x, y;
  };
  std::size_t sweep_upwards(const ObstacleMap& map, std::size_t cells);
  std::size_t sweep_downwards(std::size_t cells);
  void read_row(const ObstacleMap& map);
  bool take(std::size_t to, std::size_t from, double x, double y);
  double middle(std::int32_t column) const { return (column + 0.5) * cell_; }

  WayCost cost_;
  MapWindow window_{0, 0, 0, 0};
  double cell_ = 0.0;
  Stage stage_ = Stage::kDone;
  std::int32_t row_ = 0;
  std::vector<Point> nearest_;         // the nearest point of every cell, kNoPoint where farther than comfort
  std::vector<std::uint8_t> avoided_;  // of every cell, as in the map
};

}  // namespace edgefusion
