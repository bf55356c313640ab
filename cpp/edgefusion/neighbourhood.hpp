// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <array>
#include <cstdint>

#include "edgefusion/grid.hpp"

namespace edgefusion {

/// The occupied cells of one row that are at most two columns away: neighbours in memory as well.
struct Span {
  std::uint32_t begin;
  std::uint32_t end;
  std::uint32_t row_end;
};

/// All occupied cells that a point of the present cell can reach, as one span for each row, the nearest rows first.
class Neighbourhood {
 public:
  Neighbourhood(const Grid& grid, std::size_t row) : column_(grid.column.data()) {
    // Rows without points are not stored: the row two below may be the next but one entry, the next or none.
    for (const int step : {0, -1, 1, -2, 2}) add_row(grid, row, step);
  }

  /// Moves on to a cell further along the row; over a whole row that takes linear time.
  void slide_to(std::uint32_t cell) {
    const std::uint32_t column = column_[cell];
    for (std::size_t i = 0; i < size_; ++i) {
      Span& span = spans_[i];
      while (span.begin < span.row_end && column_[span.begin] + 2 < column) ++span.begin;
      while (span.end < span.row_end && column_[span.end] <= column + 2) ++span.end;
    }
  }

  const Span* begin() const { return spans_.data(); }
  const Span* end() const { return spans_.data() + size_; }

 private:
  void add_row(const Grid& grid, std::size_t row, int step) {
    const std::int64_t other = static_cast<std::int64_t>(row) + step;
    if (other < 0 || other + 1 >= static_cast<std::int64_t>(grid.rows.size())) return;
    const GridRow& near = grid.rows[static_cast<std::size_t>(other)];
    const std::int64_t apart = std::int64_t{near.number} - std::int64_t{grid.rows[row].number};
    if (apart < -2 || apart > 2) return;
    spans_[size_++] = {near.first_cell, near.first_cell, (&near)[1].first_cell};
  }

  const std::uint32_t* column_;
  std::array<Span, 5> spans_;
  std::size_t size_ = 0;
};

/// Calls visit(cell, neighbourhood) for every cell that is wanted(cell), in the grid's order.
template <typename Wanted, typename Visit>
void for_each_cell(const Grid& grid, Wanted wanted, Visit visit) {
  for (std::size_t row = 0; row + 1 < grid.rows.size(); ++row) {
    Neighbourhood near(grid, row);
    for (std::uint32_t cell = grid.rows[row].first_cell; cell < grid.rows[row + 1].first_cell; ++cell) {
      if (!wanted(cell)) continue;
      near.slide_to(cell);
      visit(cell, near);
    }
  }
}

}  // namespace edgefusion
