// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <vector>

namespace edgefusion {

/// Where a base stands in the plane [m, rad].
struct Pose {
  double x, y, theta;
};

/// The hull of a base seen from above: a convex polygon about the middle of its axle.
class Footprint {
 public:
  /// corners  n x 2, row major, in the base's frame [m], in either sense of rotation
  ///
  /// Throws std::invalid_argument for fewer than 3 corners, coordinates that are not finite, a polygon that is not
  /// convex and one that does not hold the origin.
  Footprint(const double* corners, std::size_t n);

  /// Of the largest circle about the origin that the hull holds, and of the smallest that holds the hull [m].
  double inscribed() const { return inscribed_; }
  double circumscribed() const { return circumscribed_; }

  /// From the hull to a point (x, y) in the base's frame, below 0 inside. Outside, the largest distance from one of
  /// the lines that the edges lie on: near a corner less than the true one, never more.
  double gap(double x, double y) const {
    double largest = edges_[0].normal_x * x + edges_[0].normal_y * y - edges_[0].offset;
    for (std::size_t i = 1; i < edges_.size(); ++i) {
      const double gap = edges_[i].normal_x * x + edges_[i].normal_y * y - edges_[i].offset;
      largest = gap > largest ? gap : largest;
    }
    return largest;
  }

  /// Where the hull reaches to along the base's x axis [m].
  double front() const { return front_; }
  double back() const { return back_; }

 private:
  struct Edge {
    double normal_x, normal_y, offset;  // the hull is where normal * p <= offset
  };
  std::vector<Edge> edges_;
  double inscribed_, circumscribed_, front_, back_;
};

}  // namespace edgefusion
