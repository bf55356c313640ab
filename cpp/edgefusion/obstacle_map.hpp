// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "edgefusion/footprint.hpp"

namespace edgefusion {

/// One sweep of a laser. The beams may be measured from different poses: the base drives meanwhile.
struct LaserScan {
  const double* poses;  ///< n x 3, row major: the laser's x, y, theta in the map at each beam
  const float* ranges;  ///< n; NaN unknown, +inf free up to range_max, -inf nearer than range_min
  std::size_t n;
  double angle_min, angle_increment, range_min, range_max;
};

/// A rectangle of cells, by their columns and rows: column c covers x from c * cell to (c + 1) * cell.
struct MapWindow {
  std::int32_t column, row, columns, rows;

  bool holds(std::int32_t c, std::int32_t r) const {
    return c >= column && c < column + columns && r >= row && r < row + rows;
  }
  std::size_t index(std::int32_t c, std::int32_t r) const {
    return static_cast<std::size_t>(r - row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(c - column);
  }
  std::size_t size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  bool operator==(const MapWindow& o) const {
    return column == o.column && row == o.row && columns == o.columns && rows == o.rows;
  }
};

/// What the laser has seen so far, in cells. A cell remembers the mean of the points seen in it, so that a gap is
/// as wide as it is, not as wide as cells make it, and how far they reach, so that no corner is hidden by a mean.
class ObstacleMap {
 public:
  struct End {
    float x = 0.0f, y = 0.0f;
  };
  struct Cell {
    float x = 0.0f, y = 0.0f;   // mean of the points seen here [m]
    End left, right;            // how far they reach across the beams
    std::uint8_t evidence = 0;  // above 0: something is here
    std::uint8_t points = 0;    // how many the mean is of, up to a limit
    std::uint8_t hits = 0;      // how many beams ended here lately, beside how many in its neighbours
    std::uint8_t passed = 0;    // how many beams came through its middle, up to a limit
    std::uint8_t avoided = 0;   // how often the base failed to get through here
    std::uint32_t born_ms = 0;  // since when something is here that was not, where beams came through before
    bool born = false;          // ... which was the case
    std::uint8_t seen = 0;      // a beam came through, or ended here, or the base stood here
  };

  /// Throws std::invalid_argument for a cell that is not finite and at least 0.01 m.
  explicit ObstacleMap(double cell);

  double cell() const { return cell_; }
  const MapWindow& window() const { return window_; }
  const Cell& at(std::size_t index) const { return cells_[index]; }
  std::int32_t column_of(double coordinate) const;

  /// Makes the window hold the base, and the target where both fit into 60 x 60 m, with 5 m around either. It grows,
  /// and moves where growing is not enough: what it leaves behind is forgotten.
  ///
  /// Throws std::invalid_argument for coordinates beyond 100 km.
  void cover(double x, double y, double target_x, double target_y);

  /// Marks what beams ended at, and lets fade what they came through: a near point that one beam saw counts at once.
  /// now_ms: of any clock that counts up, and may wrap.
  void insert(const LaserScan& scan, std::uint32_t now_ms);

  /// For how long something has been where (x, y) is, which was seen free before [s]; infinity where it was always
  /// there, as far as is known, and where nothing is.
  double age(double x, double y, std::uint32_t now_ms) const;

  /// Where the base stands there is nothing else, as far as `inset` inside its hull: whatever was seen there has gone,
  /// or was never where it seemed.
  void stand(const Footprint& footprint, const Pose& pose, double inset);

  /// Remembers that the base failed to get through here: ways through a circle of this radius are longer from now on.
  void avoid(double x, double y, double radius);

  /// Appends the points (x, y) within a square of half side `reach` about (x, y), and of the ground behind them that
  /// was never seen the middles of cells as far as `depth`: what was seen from one side has another. Points are moved by
  /// what their noise may be to a surface in the next cell.
  void points_near(double x, double y, double reach, double depth, std::vector<double>& points) const;

  /// Whether a beam has ever come through here, or the base.
  bool seen(double x, double y) const;

 private:
  struct Point {
    double x, y;
  };
  static Point to_surface(const Cell& cell, double x, double y);
  Point surface(std::int32_t column, std::int32_t row) const;
  void stretch(Cell& cell, double x, double y, double dx, double dy);
  bool near_point(std::int32_t column, std::int32_t row, std::int32_t cells) const;
  void count(std::int32_t column, std::int32_t row);
  void resize(const MapWindow& window);
  void hit(double x, double y, double dx, double dy, std::uint32_t now_ms);
  void trace(double x, double y, double dx, double dy, double length);
  template <typename Visit>
  void for_cells_near(double x, double y, double reach, Visit&& visit) const;

  double cell_;
  MapWindow window_{0, 0, 0, 0};
  std::vector<Cell> cells_;
};

}  // namespace edgefusion
