// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>

namespace edgefusion {

/// What a cluster is split by. eps and min_points are DBSCAN's, for what is left.
struct SplitRule {
  double sigma_m;  ///< noise of a beam
  double eps;
  int min_points;
};

/// Splits clusters in which something stands before a straight face: an object at a wall, or beside a deeper one.
///
/// Seen from the laser a single object is convex: none of its points is nearer than the line along one of its
/// faces. Where points are, the face (everything along its line, on both sides of what stands before it) becomes
/// a cluster of its own, the rest is clustered again, and so on. Two faces that are flush stay one cluster; an
/// object with a deep hollow, as a desk may have, comes apart.
///
/// points  n x 2, row major, in the laser's frame [m], in the order of the beams
/// labels  n cluster labels from 0, kNoise for none, rewritten: new clusters get labels from the number of clusters
///
/// Throws std::invalid_argument for a coordinate that is not finite, a sigma_m or eps that is not finite and above
/// 0, min_points < 1, and a label below kNoise.
void split_clusters(const double* points, std::size_t n, const SplitRule& rule, std::int32_t* labels);

}  // namespace edgefusion
