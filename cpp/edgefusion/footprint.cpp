// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "edgefusion/refuse.hpp"

namespace edgefusion {

Footprint::Footprint(const double* corners, std::size_t n) {
  if (n < 3) refuse("footprint: expected at least 3 corners, got ", n);
  expect_finite("footprint", corners, 2 * n);
  double doubled_area = 0.0;
  for (std::size_t i = 0, j = n - 1; i < n; j = i++)
    doubled_area += corners[2 * j] * corners[2 * i + 1] - corners[2 * i] * corners[2 * j + 1];
  const double sense = doubled_area < 0.0 ? -1.0 : 1.0;
  inscribed_ = std::numeric_limits<double>::infinity();
  circumscribed_ = 0.0;
  front_ = back_ = corners[0];
  for (std::size_t i = 0; i < n; ++i) {
    const double* a = corners + 2 * i;
    const double* b = corners + 2 * ((i + 1) % n);
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    if (!(length > 0.0)) refuse("footprint: corner ", i, " and the next are the same");
    const double nx = sense * (b[1] - a[1]) / length, ny = -sense * (b[0] - a[0]) / length;
    const double offset = nx * a[0] + ny * a[1];
    for (std::size_t k = 0; k < n; ++k)
      if (nx * corners[2 * k] + ny * corners[2 * k + 1] > offset + 1e-9)
        refuse("footprint: expected a convex polygon, got one with corner ", k,
               " beyond the edge from corner ", i);
    if (!(offset > 0.0)) refuse("footprint: expected the origin, the middle of the axle, inside");
    edges_.push_back({nx, ny, offset});
    inscribed_ = std::min(inscribed_, offset);
    circumscribed_ = std::max(circumscribed_, std::hypot(a[0], a[1]));
    front_ = std::max(front_, a[0]);
    back_ = std::min(back_, a[0]);
  }
}

}  // namespace edgefusion
