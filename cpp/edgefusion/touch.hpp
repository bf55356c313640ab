// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>

#include "edgefusion/ball.hpp"
#include "edgefusion/grid.hpp"

namespace edgefusion {

/// Neighbouring points of a grid.
struct PointRange {
  std::uint32_t begin;
  std::uint32_t end;
};

/// Whether some point of `a` reaches some point of `b`. Near-linear in their sizes.
bool touch(const Grid& grid, const Ball& ball, PointRange a, PointRange b);

}  // namespace edgefusion
