// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "edgefusion/ball.hpp"
#include "edgefusion/points.hpp"

namespace edgefusion {

/// The points near a cell, copied side by side. Most cells have about ten of them in several places: fetched once,
/// they are compared in one loop, of which the processor mispredicts no more than the end.
class NearPoints {
 public:
  explicit NearPoints(const Ball& ball) : ball_(ball), points_(kBlock) {}

  void clear() { size_ = 0; }
  bool empty() const { return size_ == 0; }

  void append(const Points& from, PointRange range) {
    const std::uint32_t size = size_ + (range.end - range.begin);
    if (size + kBlock > points_.x.size()) grow(size);
    std::uint32_t to = size_;
    do {
      std::copy_n(&from.x[range.begin], kStep, &points_.x[to]);
      std::copy_n(&from.y[range.begin], kStep, &points_.y[to]);
      std::copy_n(&from.number[range.begin], kStep, &points_.number[to]);
      range.begin += kStep;
      to += kStep;
    } while (to < size);
    size_ = size;
  }

  /// To be called after the last append: fills the last block with points that nothing reaches.
  void close() {
    std::fill_n(&points_.x[size_], kBlock, std::numeric_limits<double>::infinity());
  }

  /// How many points the ball around (x, y) reaches; stops soon after `enough`.
  std::uint32_t count(double x, double y, std::uint32_t enough) const {
    std::uint32_t count = 0;
    for (std::uint32_t block = 0; block < size_ && count < enough; block += kBlock)
      for (std::uint32_t i = block; i < block + kBlock; ++i) count += reaches(x, y, i);
    return count;
  }

  /// The lowest number of the points that the ball around (x, y) reaches, or the highest of all numbers.
  std::uint32_t lowest_number(double x, double y) const {
    std::uint32_t lowest = std::numeric_limits<std::uint32_t>::max();
    for (std::uint32_t block = 0; block < size_; block += kBlock) {
      for (std::uint32_t i = block; i < block + kBlock; ++i) {
        const std::uint32_t reached = reaches(x, y, i);
        lowest = std::min(lowest, points_.number[i] | (reached - 1));  // all ones where it is not reached
      }
    }
    return lowest;
  }

 private:
  static constexpr std::uint32_t kBlock = 8;
  static constexpr std::uint32_t kStep = 4;

  bool reaches(double x, double y, std::uint32_t i) const {
    return ball_.reaches(points_.x[i] - x, points_.y[i] - y);
  }

  void grow(std::uint32_t size) {
    Points larger(2 * std::size_t{size});
    std::copy_n(points_.x.begin(), size_, larger.x.begin());
    std::copy_n(points_.y.begin(), size_, larger.y.begin());
    std::copy_n(points_.number.begin(), size_, larger.number.begin());
    points_ = std::move(larger);
  }

  Ball ball_;
  Points points_;
  std::uint32_t size_ = 0;
};

}  // namespace edgefusion
