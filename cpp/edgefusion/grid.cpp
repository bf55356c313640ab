// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/grid.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "edgefusion/ball.hpp"
#include "edgefusion/radix_sort.hpp"

namespace edgefusion {
namespace {

// A cell's side in units of eps. Below sqrt(1/2), so that the diagonal is shorter than eps by far more than
// any rounding here; above 1/2, so that what lies three cells away is farther than eps, by as wide a margin.
constexpr double kSide = 0.7;

// Up to here an interval's number, computed in doubles, is right to a millionth of an interval.
constexpr double kMaxEvenIntervals = 1 << 30;

// The intervals of one axis: the number of each point's, numbers below `count`.
struct Intervals {
  std::vector<std::uint32_t> of_point;
  std::uint32_t count;
};

Intervals even_intervals(const double* values, std::size_t n, double low, double high, double per_unit) {
  Intervals intervals{std::vector<std::uint32_t>(n), static_cast<std::uint32_t>((high - low) * per_unit) + 1};
  for (std::size_t i = 0; i < n; ++i)
    intervals.of_point[i] =
        static_cast<std::uint32_t>(static_cast<std::int32_t>((values[2 * i] - low) * per_unit));
  return intervals;
}

// For any extent: each interval starts at the lowest value that the last one does not hold. Three apart still
// means farther than eps, since there are two whole sides in between.
Intervals greedy_intervals(const double* values, std::size_t n, const Ball& ball) {
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  const auto value = [values](std::uint32_t i) { return values[2 * std::size_t{i}]; };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return value(a) < value(b); });
  Intervals intervals{std::vector<std::uint32_t>(n), 1};
  double start = value(order.front());
  for (const std::uint32_t i : order) {
    if (!ball.spans(value(i) - start, kSide)) {
      start = value(i);
      ++intervals.count;
    }
    intervals.of_point[i] = intervals.count - 1;
  }
  return intervals;
}

// Splits one axis; `values` are two apart in memory.
Intervals split_axis(const double* values, std::size_t n, double eps) {
  double low = values[0];
  double high = values[0];
  for (std::size_t i = 1; i < n; ++i) {
    low = std::min(low, values[2 * i]);
    high = std::max(high, values[2 * i]);
  }
  const double per_unit = 1.0 / (kSide * eps);
  const bool few = (high - low) * per_unit < kMaxEvenIntervals;  // false for inf and NaN too
  return few ? even_intervals(values, n, low, high, per_unit) : greedy_intervals(values, n, Ball(eps));
}

int bit_width(std::uint32_t value) {
  int bits = 0;
  for (; value != 0; value >>= 1) ++bits;
  return bits;
}

std::vector<Keyed> sorted_by_cell(const Intervals& rows, const Intervals& columns, int column_bits) {
  std::vector<Keyed> records(rows.of_point.size());
  for (std::uint32_t i = 0; i < records.size(); ++i)
    records[i] = {std::uint64_t{rows.of_point[i] + 2} << column_bits | (columns.of_point[i] + 2), i};
  radix_sort(records, column_bits + bit_width(rows.count + 1));
  return records;
}

void gather_points(Points& points, const std::vector<Keyed>& records, const double* from) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::uint32_t row = records[i].row;
    points.x[i] = from[2 * std::size_t{row}];
    points.y[i] = from[2 * std::size_t{row} + 1];
    points.number[i] = row;
  }
}

// A cell for every change of the key. Where it changes cannot be predicted, so nothing branches on it.
void mark_cells(Grid& grid, const std::vector<Keyed>& records) {
  grid.begin.resize(records.size() + 1);
  grid.key.resize(records.size() + Grid::kPadding);
  std::size_t cells = 0;
  for (std::uint32_t i = 0; i < records.size(); ++i) {
    cells += i == 0 || records[i].key != records[i - 1].key;
    grid.key[cells - 1] = records[i].key;
    grid.begin[cells] = i + 1;
  }
  grid.begin.resize(cells + 1);
  grid.key.resize(cells);
  grid.key.resize(cells + Grid::kPadding, std::numeric_limits<std::uint64_t>::max());
}

}  // namespace

Grid make_grid(const double* points, std::size_t n, double eps) {
  const Intervals columns = split_axis(points, n, eps);
  const Intervals rows = split_axis(points + 1, n, eps);
  const int column_bits = bit_width(columns.count + 3);  // two columns more on either side, for neighbours
  const std::vector<Keyed> records = sorted_by_cell(rows, columns, column_bits);
  Grid grid(n);
  gather_points(grid.points, records, points);
  mark_cells(grid, records);
  grid.row_stride = std::uint64_t{1} << column_bits;
  return grid;
}

}  // namespace edgefusion
