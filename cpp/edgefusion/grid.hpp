// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "edgefusion/ball.hpp"

namespace edgefusion {

/// A row of cells that holds at least one point.
struct GridRow {
  std::uint32_t number;
  std::uint32_t first_cell;
};

/// Points sorted into the occupied cells of a grid, cells sorted by row, then column.
///
/// A cell is so small that all its points reach each other; points that reach each other are at most two rows and
/// two columns apart. Nothing is stored for an empty cell, so memory is linear whatever the extent.
struct Grid {
  std::vector<double> x;               ///< of each point, cell by cell
  std::vector<double> y;
  std::vector<std::uint32_t> index;    ///< of each point: its row in the input
  std::vector<std::uint32_t> begin;    ///< of each cell: its first point; one more ends the last cell
  std::vector<std::uint32_t> column;   ///< of each cell
  std::vector<GridRow> rows;           ///< one more ends the last row

  std::uint32_t cell_count() const { return static_cast<std::uint32_t>(column.size()); }
  std::uint32_t size(std::uint32_t cell) const { return begin[cell + 1] - begin[cell]; }
};

/// points: n x 2, row major, finite, n below 2^31.
Grid make_grid(const double* points, std::size_t n, double eps);

}  // namespace edgefusion
