// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>
#include <vector>

namespace edgefusion {

/// A key to sort by and the row of the input that it belongs to.
struct Keyed {
  std::uint64_t key;
  std::uint32_t row;
};

/// Sorts by key in linear time, equal keys in their present order. No key may have a bit at or above `bits`.
void radix_sort(std::vector<Keyed>& records, int bits);

}  // namespace edgefusion
