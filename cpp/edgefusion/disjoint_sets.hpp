// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace edgefusion {

/// Disjoint sets of 0 .. n-1 (union-find). A set is named by its lowest element.
class DisjointSets {
 public:
  explicit DisjointSets(std::uint32_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::uint32_t find(std::uint32_t element) {
    while (parent_[element] != element) {
      parent_[element] = parent_[parent_[element]];  // halves the path for the next one
      element = parent_[element];
    }
    return element;
  }

  /// Joins the sets of two roots; returns the root of both.
  std::uint32_t join(std::uint32_t root_a, std::uint32_t root_b) {
    if (root_b < root_a) std::swap(root_a, root_b);
    parent_[root_b] = root_a;
    return root_a;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace edgefusion
