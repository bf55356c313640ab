// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "edgefusion/obstacle_map.hpp"

namespace edgefusion {

/// How obstacles make ways longer.
struct WayCost {
  double blocked;  ///< the base's middle never comes nearer to a point than this [m]
  double comfort;  ///< from here on obstacles are of no account [m]; in between ways cost more
  double weight;   ///< a metre right beside what is blocked counts 1 + weight
};

enum class Outcome : std::int32_t { kReached, kEnclosed, kOccupied };

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

  /// Does so many cells' work of what was begun; true when it is done, and in use. The map may have been changed
  /// meanwhile, but where its window has, it is begun anew with the same goal.
  bool advance(const ObstacleMap& map, std::size_t cells);

  bool running() const { return stage_ != Stage::kIdle; }

  /// Of the one in use. Nothing was computed yet: kReached, and values of infinity.
  Outcome outcome() const { return field_.outcome; }

  /// The potential between cells [m], infinity where there is no way or it is not known.
  double value(double x, double y) const;

  /// The unit vector down the potential, (0, 0) where there is none.
  std::pair<double, double> descent(double x, double y) const;

  /// From (x, y) down the potential for at most `length`, in steps of half a cell; ends at the goal. Where (x, y) has
  /// no value, the way begins at the nearest cell's middle within `reach` that has.
  ///
  /// Throws std::invalid_argument for a length or reach that is not finite.
  void way(double x, double y, double length, double reach, std::vector<double>& points) const;

  /// From a cell's middle to the nearest point, as far as `comfort`; beyond, something larger.
  double clearance(double x, double y) const;

 private:
  enum class Stage { kIdle, kDown, kUp, kMarch };
  struct Point {
    float x, y;
  };
  struct Field {
    MapWindow window{0, 0, 0, 0};
    double cell = 0.0;
    std::vector<float> values;   // T of every cell, infinity where unknown
    std::vector<Point> nearest;  // the nearest point of every cell, kNoPoint where farther than comfort
    double goal_x = 0.0, goal_y = 0.0;
    Outcome outcome = Outcome::kReached;
  };
  struct Entry {
    float value;
    std::int32_t index;
    bool operator<(const Entry& o) const { return value > o.value; }  // the lowest on top of the heap
  };

  void restart(const ObstacleMap& map);
  std::size_t sweep_down(const ObstacleMap& map, std::size_t cells);
  std::size_t sweep_up(std::size_t cells);
  void seed();
  void seed_goal();
  void seed_border();
  std::size_t base_cell() const;
  std::size_t march(std::size_t cells);
  void relax(std::int32_t column, std::int32_t row);
  void offer(std::size_t index, float value);
  void finish(Outcome outcome);
  bool take(std::size_t to, std::size_t from, double x, double y);
  double middle(std::int32_t column) const { return (column + 0.5) * next_.cell; }
  float cost_at(std::size_t index, std::int32_t column, std::int32_t row) const;
  std::pair<double, double> slope(std::int32_t column, std::int32_t row) const;
  float value_at(std::int32_t column, std::int32_t row) const;

  WayCost cost_;
  Field field_, next_;
  Stage stage_ = Stage::kIdle;
  std::int32_t row_ = 0;
  double tolerance_ = 0.0, base_x_ = 0.0, base_y_ = 0.0;
  float stop_at_ = 0.0f;  // marching ends beyond this value
  std::size_t base_ = 0;  // the cell that it is to pass
  std::vector<Entry> heap_;
  std::vector<std::uint8_t> settled_;
  std::vector<std::uint8_t> avoided_;  // of every cell, as in the map
};

}  // namespace edgefusion
