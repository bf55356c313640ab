// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// The grid makes DBSCAN linear (Gunawan 2013): all points of a cell reach each other, so a cell with
// min_points points needs no distance at all, and the core points of a cell always share a cluster, so
// clusters are joined cell by cell.
#include "edgefusion/dbscan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "edgefusion/ball.hpp"
#include "edgefusion/disjoint_sets.hpp"
#include "edgefusion/grid.hpp"
#include "edgefusion/neighbourhood.hpp"
#include "edgefusion/points.hpp"
#include "edgefusion/refuse.hpp"
#include "edgefusion/touch.hpp"

namespace edgefusion {
namespace {

void check(const double* points, std::size_t n, double eps, int min_points) {
  if (!(eps > 0.0 && std::isfinite(eps))) refuse("eps: expected a finite number above 0, got ", eps);
  if (min_points < 1) refuse("min_points: expected at least 1, got ", min_points);
  if (n > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    refuse("points: expected fewer than 2^31 rows, got ", n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(points[2 * i]) || !std::isfinite(points[2 * i + 1]))
      refuse("points: expected finite coordinates, got (", points[2 * i], ", ", points[2 * i + 1],
             ") in row ", i);
  }
}

class Clustering {
 public:
  Clustering(const double* points, std::size_t n, double eps, std::uint32_t min_points)
      : grid_(make_grid(points, n, eps)),
        ball_(eps),
        min_points_(min_points),
        cores_(n),
        cores_begin_(grid_.cell_count() + std::size_t{1}),
        others_(n + std::size_t{1}),
        others_begin_(grid_.cell_count() + std::size_t{1}),
        clusters_(grid_.cell_count()) {}

  void label(std::int32_t* labels) {
    find_clusters();
    number_clusters(labels);
    label_borders(labels);
  }

 private:
  PointRange points(std::uint32_t cell) const { return {grid_.begin[cell], grid_.begin[cell + 1]}; }
  PointRange points(const CellRange& cells) const {
    return {grid_.begin[cells.begin], grid_.begin[cells.end]};
  }
  PointRange cores(std::uint32_t cell) const { return {cores_begin_[cell], cores_begin_[cell + 1]}; }
  PointRange cores(const CellRange& cells) const {
    return {cores_begin_[cells.begin], cores_begin_[cells.end]};
  }
  bool has_core(std::uint32_t cell) const { return cores_begin_[cell] < cores_begin_[cell + 1]; }
  PointRange others(std::uint32_t cell) const { return {others_begin_[cell], others_begin_[cell + 1]}; }

  void find_clusters() {
    Neighbourhood near(grid_);
    for (std::uint32_t cell = 0; cell < grid_.cell_count(); ++cell) {
      near.slide_to(cell);
      find_cores(cell, near);
      if (has_core(cell)) connect_to_earlier(cell, near);
    }
  }

  void find_cores(std::uint32_t cell, const Neighbourhood& near) {
    const std::uint32_t in_cell = grid_.begin[cell + 1] - grid_.begin[cell];
    if (in_cell >= min_points_) return sort_points(cell, [in_cell](std::uint32_t) { return in_cell; });
    const std::uint32_t in_sight = count(near);
    if (in_sight < min_points_) return sort_points(cell, [in_sight](std::uint32_t) { return in_sight; });
    sort_points(cell, [this, &near](std::uint32_t point) { return count_reached(point, near); });
  }

  // Sorts a cell's points into core points, others and those that reach nobody. Which of them a point is
  // cannot be predicted, so it is written to both lists and only one of them moves on.
  template <typename Count>
  void sort_points(std::uint32_t cell, Count count_of) {
    std::uint32_t core = cores_begin_[cell];
    std::uint32_t other = others_begin_[cell];
    for (std::uint32_t point = grid_.begin[cell]; point < grid_.begin[cell + 1]; ++point) {
      cores_.x[core] = grid_.points.x[point];
      cores_.y[core] = grid_.points.y[point];
      cores_.number[core] = grid_.points.number[point];
      others_[other] = point;
      const std::uint32_t count = count_of(point);
      core += count >= min_points_;
      other += (count < min_points_) & (count > 1);
    }
    cores_begin_[cell + 1] = core;
    others_begin_[cell + 1] = other;
  }

  std::uint32_t count(const Neighbourhood& near) const {
    std::uint32_t count = 0;
    for (const CellRange& cells : near) count += grid_.begin[cells.end] - grid_.begin[cells.begin];
    return count;
  }

  // How many points it reaches, itself included, but no more than a few above min_points.
  std::uint32_t count_reached(std::uint32_t point, const Neighbourhood& near) const {
    std::uint32_t count = 0;
    for (const CellRange& cells : near) {
      count += count_reached(point, points(cells), min_points_ - count);
      if (count >= min_points_) break;
    }
    return count;
  }

  // Stops soon after `enough`. Four at a time and no branch for each: a row of cells in a sparse grid has
  // about two points.
  std::uint32_t count_reached(std::uint32_t point, PointRange range, std::uint32_t enough) const {
    const double px = grid_.points.x[point];
    const double py = grid_.points.y[point];
    std::uint32_t count = 0;
    for (std::uint32_t j = range.begin; j < range.end && count < enough; j += 4) {
      const double* const x = &grid_.points.x[j];
      const double* const y = &grid_.points.y[j];
      const std::uint32_t left = range.end - j;
      for (std::uint32_t i = 0; i < 4; ++i) count += ball_.reaches(x[i] - px, y[i] - py) & (i < left);
    }
    return count;
  }

  // Each pair of cells is connected once, when the later one is visited: the cores of the earlier are known.
  void connect_to_earlier(std::uint32_t cell, const Neighbourhood& near) {
    std::uint32_t root = cell;
    for (const CellRange& cells : near) {
      for (std::uint32_t other = cells.begin; other < std::min(cells.end, cell); ++other) {
        if (!has_core(other)) continue;
        const std::uint32_t other_root = clusters_.find(other);
        if (other_root != root && touch(cores_, ball_, cores(cell), cores(other)))
          root = clusters_.join(root, other_root);
      }
    }
  }

  // In the order of the input, so that the cluster with the lowest core index comes first.
  void number_clusters(std::int32_t* labels) {
    const std::uint32_t n = grid_.point_count();
    std::fill_n(labels, n, kNoise);
    for (std::uint32_t cell = 0; cell < grid_.cell_count(); ++cell) {
      const auto root = static_cast<std::int32_t>(clusters_.find(cell));
      const PointRange range = cores(cell);
      for (std::uint32_t core = range.begin; core < range.end; ++core) labels[cores_.number[core]] = root;
    }
    std::vector<std::int32_t> number(grid_.cell_count(), kNoise);
    std::int32_t next = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (labels[i] == kNoise) continue;
      std::int32_t& of_root = number[static_cast<std::size_t>(labels[i])];
      if (of_root == kNoise) of_root = next++;
      labels[i] = of_root;
    }
    for (std::uint32_t core = 0; core < cores_begin_.back(); ++core)
      cores_.number[core] = static_cast<std::uint32_t>(labels[cores_.number[core]]);
  }

  // Every other point joins the lowest cluster that has a core point within its reach.
  void label_borders(std::int32_t* labels) {
    Neighbourhood near(grid_);
    for (std::uint32_t cell = 0; cell < grid_.cell_count(); ++cell) {
      const PointRange range = others(cell);
      if (range.begin == range.end) continue;
      near.slide_to(cell);
      for (std::uint32_t i = range.begin; i < range.end; ++i)
        labels[grid_.points.number[others_[i]]] = lowest_cluster(others_[i], near);
    }
  }

  // Unsigned, noise is the highest number of all, and what is not reached is made noise: no branch is needed.
  std::int32_t lowest_cluster(std::uint32_t point, const Neighbourhood& near) const {
    const double px = grid_.points.x[point];
    const double py = grid_.points.y[point];
    auto lowest = static_cast<std::uint32_t>(kNoise);
    for (const CellRange& cells : near) {
      const PointRange range = cores(cells);
      for (std::uint32_t j = range.begin; j < range.end; j += 4) {
        const double* const x = &cores_.x[j];
        const double* const y = &cores_.y[j];
        const std::uint32_t* const cluster = &cores_.number[j];
        const std::uint32_t left = range.end - j;
        for (std::uint32_t i = 0; i < 4; ++i) {
          const std::uint32_t reached = ball_.reaches(x[i] - px, y[i] - py) & (i < left);
          lowest = std::min(lowest, cluster[i] | (reached - 1));
        }
      }
    }
    return static_cast<std::int32_t>(lowest);
  }

  Grid grid_;
  Ball ball_;
  std::uint32_t min_points_;
  Points cores_;                            // cell by cell; numbered as in the input, then by cluster
  std::vector<std::uint32_t> cores_begin_;  // of each cell; one more ends the last cell
  std::vector<std::uint32_t> others_;       // points that are not cores but reach somebody, cell by cell
  std::vector<std::uint32_t> others_begin_;
  DisjointSets clusters_;  // of cells with core points
};

}  // namespace

void dbscan(const double* points, std::size_t n, double eps, int min_points, std::int32_t* labels) {
  check(points, n, eps, min_points);
  if (n == 0) return;
  Clustering(points, n, eps, static_cast<std::uint32_t>(min_points)).label(labels);
}

}  // namespace edgefusion
