// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "edgefusion/cost_map.hpp"
#include "edgefusion/obstacle_map.hpp"
#include "edgefusion/potential.hpp"

namespace edgefusion {

/// A potential without local minima: the length of the shortest way to the goal, longer near obstacles, from the
/// eikonal equation |grad T| = cost, solved by fast marching (Sethian 1996). Unknown ground is passable.
///
/// It is computed anew in portions while the last one stays in use, so that a step of the base takes no longer on a
/// large map. It ends as soon as it has passed the base.
class NavigationFunction {
 public:
  /// Throws std::invalid_argument for a cost that is not finite or below 0, and comfort not above blocked.
  explicit NavigationFunction(const WayCost& cost);

  /// Begins anew, from a goal that counts as reached within `tolerance` [m]. A goal outside of the map's window is
  /// beyond free ground: then the marching starts at the window's border, with the distances from there.
  ///
  /// Throws std::invalid_argument for coordinates beyond 100 km and a tolerance below 0.
  void begin(const ObstacleMap& map, double goal_x, double goal_y, double tolerance, double x, double y);

  /// Does so many cells' work of what was begun, on large maps more as long as that is quick; true when it is done, and
  /// in use. The map may have been changed meanwhile, but where its window has, it is begun anew with the same goal.
  bool advance(const ObstacleMap& map, std::size_t cells);

  bool running() const { return stage_ != Stage::kIdle; }

  /// The one in use.
  const Potential& potential() const { return potential_; }

 private:
  enum class Stage { kIdle, kCosts, kMarch };
  struct Entry {
    float value;
    std::int32_t index;
    bool operator<(const Entry& o) const { return value > o.value; }  // the lowest on top of the heap
  };

  void restart(const ObstacleMap& map);
  void seed();
  void seed_goal();
  void seed_border();
  std::size_t base_cell() const;
  std::size_t march(std::size_t cells);
  void relax(std::int32_t column, std::int32_t row);
  void offer(std::size_t index, float value);
  void finish(Outcome outcome);

  CostMap costs_;
  Potential potential_, next_;
  Stage stage_ = Stage::kIdle;
  double tolerance_ = 0.0, base_x_ = 0.0, base_y_ = 0.0;
  float stop_at_ = 0.0f;  // marching ends beyond this value
  std::size_t base_ = 0;  // the cell that it is to pass
  std::vector<Entry> heap_;
  std::vector<std::uint8_t> settled_;
};

}  // namespace edgefusion
