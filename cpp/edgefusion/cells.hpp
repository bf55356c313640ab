// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "edgefusion/refuse.hpp"

namespace edgefusion {

/// The largest whole number that is not above; NaN, and what is farther away than any map, is farther away than any map.
inline std::int32_t floored(double value) {
  constexpr double kFar = 1 << 29;  // so that sums of two stay whole numbers of 32 bits
  if (!(value > -kFar)) return static_cast<std::int32_t>(-kFar);
  return static_cast<std::int32_t>(value < kFar ? std::floor(value) : kFar);
}

/// Refuses coordinates that a map does not hold to a centimetre in single precision: those beyond 100 km.
inline void expect_on_map(const char* name, const double* coordinates, std::size_t n) {
  expect_finite(name, coordinates, n);
  for (std::size_t i = 0; i < n; ++i)
    if (std::abs(coordinates[i]) > 1e5) refuse(name, ": expected at most 100 km, got ", coordinates[i], " m");
}

}  // namespace edgefusion
