// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "edgefusion/cells.hpp"
#include "edgefusion/obstacle_map.hpp"

namespace edgefusion {

/// What came of a computation: a way from the base, none, or no room for it at the goal.
enum class Outcome : std::int32_t { kReached, kEnclosed, kOccupied };

/// Where there is no way, or none is known.
constexpr float kNever = std::numeric_limits<float>::infinity();

/// A potential on cells, read between them. A new one has no cells, and kReached as its outcome.
struct Potential {
  MapWindow window{0, 0, 0, 0};
  double cell = 0.0;
  std::vector<float> values;  ///< of every cell [m]; kNever where there is no way or it is not known
  double goal_x = 0.0, goal_y = 0.0;
  Outcome outcome = Outcome::kReached;

  /// The mixture of the four cells around (x, y) [m]; infinity where none of them has a value.
  double value(double x, double y) const;

  /// The unit vector down the potential, (0, 0) where there is none.
  std::pair<double, double> descent(double x, double y) const;

  /// From (x, y) down the potential for at most `length`, in steps of half a cell; ends at the goal. Where (x, y) has
  /// no value, the way begins at the nearest cell's middle within `reach` that has.
  ///
  /// Throws std::invalid_argument for a length or reach that is not finite.
  void way(double x, double y, double length, double reach, std::vector<double>& points) const;

  double middle(std::int32_t column) const { return (column + 0.5) * cell; }

 private:
  float value_at(std::int32_t column, std::int32_t row) const;
  std::pair<double, double> slope(std::int32_t column, std::int32_t row) const;
  bool begin_nearby(double reach, double& x, double& y) const;
};

/// The nearest cell within reach that is fit; the window's size where there is none.
template <typename Fit>
std::size_t nearest_cell(const MapWindow& w, double cell, double x, double y, double reach, Fit&& fit) {
  std::size_t found = w.size();
  double nearest = reach;
  const std::int32_t last = std::min(floored((x + reach) / cell), w.column + w.columns - 1);
  const std::int32_t top = std::min(floored((y + reach) / cell), w.row + w.rows - 1);
  for (std::int32_t r = std::max(floored((y - reach) / cell), w.row); r <= top; ++r) {
    for (std::int32_t c = std::max(floored((x - reach) / cell), w.column); c <= last; ++c) {
      const double apart = std::hypot((c + 0.5) * cell - x, (r + 0.5) * cell - y);
      if (apart >= nearest || !fit(w.index(c, r), c, r)) continue;
      nearest = apart;
      found = w.index(c, r);
    }
  }
  return found;
}

}  // namespace edgefusion
