// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "edgefusion/points.hpp"

namespace edgefusion {

/// Points sorted into the occupied cells of a grid, cells sorted by row, then column.
///
/// A cell is so small that all its points reach each other; points that reach each other are at most two rows
/// and two columns apart. Nothing is stored for an empty cell, so memory is linear whatever the extent.
struct Grid {
  /// As many cells may be looked at behind the last one: their keys are higher than all.
  static constexpr std::size_t kPadding = 5;

  explicit Grid(std::size_t n) : points(n) {}

  Points points;                     ///< cell by cell, numbered as in the input
  std::vector<std::uint32_t> begin;  ///< of each cell: its first point; one more ends the last cell
  std::vector<std::uint64_t> key;    ///< of each cell: row * row_stride + column; then the padding
  std::uint64_t row_stride = 0;      ///< two columns and two rows stay free on every side

  std::uint32_t point_count() const { return begin.back(); }
  std::uint32_t cell_count() const { return static_cast<std::uint32_t>(begin.size() - 1); }
};

/// points: n x 2, row major, finite, n below 2^31.
Grid make_grid(const double* points, std::size_t n, double eps);

}  // namespace edgefusion
