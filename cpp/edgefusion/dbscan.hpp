// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>

namespace edgefusion {

/// Label of a point that belongs to no cluster.
constexpr std::int32_t kNoise = -1;

/// DBSCAN (Ester et al. 1996) of n points of the plane, in linear time at constant density.
///
/// A point is a core point when at least `min_points` points, itself included, lie within `eps` (closed
/// ball). Clusters are numbered by their lowest core index, a border point joins the lowest of the clusters
/// that reach it: the labels are those of scikit-learn.
///
/// points  n x 2, row major, any unit
/// labels  n values, written: kNoise or the cluster's number
///
/// Throws std::invalid_argument for a coordinate that is not finite, eps not finite and above 0 or min_points
/// below 1.
void dbscan(const double* points, std::size_t n, double eps, int min_points, std::int32_t* labels);

}  // namespace edgefusion
