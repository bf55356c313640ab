// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "edgefusion/grid.hpp"

namespace edgefusion {

/// The occupied cells of one row that are at most two columns away: neighbours in memory as well.
struct Span {
  std::uint32_t begin;
  std::uint32_t end;
};

/// All occupied cells that a point of the present cell can reach: one span for each row, the nearest rows
/// first.
class Neighbourhood {
 public:
  explicit Neighbourhood(const Grid& grid) : key_(grid.key.data()) {
    for (std::size_t i = 0; i < spans_.size(); ++i)
      offset_[i] = kRows[i] * grid.row_stride - 2;  // may wrap around
  }

  /// Moves on to a later cell; over the whole grid that takes linear time.
  void slide_to(std::uint32_t cell) {
    for (std::size_t i = 0; i < spans_.size(); ++i) {
      const std::uint64_t first = key_[cell] + offset_[i];
      const std::uint32_t begin = skip_below(first, spans_[i].begin);
      spans_[i] = {begin, begin + count_below<5>(first + 5, begin)};
    }
  }

  const Span* begin() const { return spans_.data(); }
  const Span* end() const { return spans_.data() + spans_.size(); }

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
  std::array<Span, 5> spans_{};
};

}  // namespace edgefusion
