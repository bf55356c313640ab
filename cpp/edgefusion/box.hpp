// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>

namespace edgefusion {

/// A box of whole pixels; x1 and y1 are exclusive.
struct Box {
  std::int32_t x0, y0, x1, y1;

  std::int32_t width() const { return x1 - x0; }
  std::int32_t height() const { return y1 - y0; }
};
static_assert(sizeof(Box) == 4 * sizeof(std::int32_t), "a row of an int32 array [n, 4] is a Box");

}  // namespace edgefusion
