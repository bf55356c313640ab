// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace edgefusion {

/// Points of the plane, each with a number that says which it is, coordinate by coordinate.
///
/// Loops take four at a time, without a branch for each, so a few may be read behind the last one.
struct Points {
  static constexpr std::size_t kPadding = 4;

  explicit Points(std::size_t n) : x(n + kPadding), y(n + kPadding), number(n + kPadding) {}

  std::vector<double> x;
  std::vector<double> y;
  std::vector<std::uint32_t> number;
};

/// Points that are neighbours in memory.
struct PointRange {
  std::uint32_t begin;
  std::uint32_t end;
};

}  // namespace edgefusion
