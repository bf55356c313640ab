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
/// that reach it: the labels are those of scikit-learn's algorithm "kd_tree" (what its "auto" takes for twelve
/// points of the plane or more), which tests dx * dx + dy * dy <= eps * eps in doubles. Its "brute" and
/// "ball_tree" round other terms; where a distance equals eps but for rounding, they may answer differently.
///
/// Memory is linear in n, whatever eps and min_points are. Time is linear too, but for points so crowded that
/// their neighbours have to be counted one by one: then it is at most proportional to n * min_points.
///
/// points  n x 2, row major, any unit
/// labels  n values, written: kNoise or the cluster's number
///
/// Throws std::invalid_argument for a coordinate that is not finite, eps not finite and above 0 or min_points
/// below 1.
void dbscan(const double* points, std::size_t n, double eps, int min_points, std::int32_t* labels);

}  // namespace edgefusion
