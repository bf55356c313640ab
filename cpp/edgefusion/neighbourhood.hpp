// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "edgefusion/grid.hpp"

namespace edgefusion {

/// The occupied cells of one row that are at most two columns away: neighbours in memory as well.
struct CellRange {
  std::uint32_t begin;
  std::uint32_t end;
};

/// All occupied cells that a point of the present cell can reach: one range for each row, the nearest first.
class Neighbourhood {
 public:
  explicit Neighbourhood(const Grid& grid) : key_(grid.key.data()) {
    for (std::size_t i = 0; i < ranges_.size(); ++i)
      offset_[i] = kRows[i] * grid.row_stride - 2;  // may wrap around
  }

  /// Moves on to a later cell; over the whole grid that takes linear time.
  void slide_to(std::uint32_t cell) {
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      const std::uint64_t first = key_[cell] + offset_[i];
      const std::uint32_t begin = skip_below(first, ranges_[i].begin);
      ranges_[i] = {begin, begin + count_below<5>(first + 5, begin)};
    }
  }

  const CellRange* begin() const { return ranges_.data(); }
  const CellRange* end() const { return ranges_.data() + ranges_.size(); }

 private:
  static constexpr std::array<std::uint64_t, 5> kRows{0, ~std::uint64_t{0}, 1, ~std::uint64_t{1}, 2};

  // How many of the next n cells have a lower key: counted, since a branch for each would be mispredicted.
  template <int n>
  std::uint32_t count_below(std::uint64_t key, std::uint32_t cell) const {
    const std::uint64_t* const keys = key_ + cell;
    std::uint32_t count = 0;
    for (int i = 0; i < n; ++i) count += keys[i] < key;
    return count;
  }

  std::uint32_t skip_below(std::uint64_t key, std::uint32_t cell) const {
    constexpr int kStep = 4;
    for (;;) {
      const std::uint32_t count = count_below<kStep>(key, cell);
      cell += count;
      if (count < kStep) return cell;
    }
  }

  const std::uint64_t* key_;
  std::array<std::uint64_t, 5> offset_;
  std::array<CellRange, 5> ranges_{};
};

}  // namespace edgefusion
