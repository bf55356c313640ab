// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>

namespace edgefusion {

/// How far away the nearest surface of a cluster is.
struct NearestRange {
  double range_m;
  double sigma_m;     ///< 1 sigma
  std::size_t index;  ///< the beam nearest to it
};

/// The paper's min(r), corrected: the minimum over noisy beams is too near, and the nearer the more beams.
///
/// The cluster's shape is estimated by a short moving mean; the bias and the spread of the minimum over beams
/// of that shape and of the given noise are integrated and undone. What lies between the beams is nearer
/// still by a part of the step to the next beam, which widens sigma too.
///
/// ranges_m  n >= 1 ranges of neighbouring beams
/// sigma_m   of one beam's noise
///
/// Throws std::invalid_argument for no ranges, one that is not finite, or a sigma_m not finite and above 0.
NearestRange nearest_range(const double* ranges_m, std::size_t n, double sigma_m);

}  // namespace edgefusion
