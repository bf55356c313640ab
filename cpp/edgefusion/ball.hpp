// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <algorithm>
#include <cmath>

namespace edgefusion {

/// The closed ball of a radius: dx * dx + dy * dy <= radius * radius, each operation rounded to a double.
/// That is the test of scikit-learn's k-d tree, not of its brute force, which expands the square.
///
/// Differences are scaled by a power of two that brings the radius near 1. That rounds nothing, and the
/// squares stay right where radius * radius itself would overflow (1e300) or vanish (1e-300).
class Ball {
 public:
  explicit Ball(double radius) {
    int exponent = 0;
    std::frexp(radius, &exponent);
    scale_ = std::ldexp(1.0, std::min(-exponent, 1000));  // 2^1000 is enough for the smallest subnormal
    scaled_radius_ = radius * scale_;
    squared_ = scaled_radius_ * scaled_radius_;
  }

  bool reaches(double dx, double dy) const {
    const double x = dx * scale_;
    const double y = dy * scale_;
    return x * x + y * y <= squared_;
  }

  /// Whether a difference along one axis is at most this fraction of the radius.
  bool spans(double difference, double fraction) const {
    return difference * scale_ <= fraction * scaled_radius_;
  }

 private:
  double scale_;
  double scaled_radius_;
  double squared_;
};

}  // namespace edgefusion
