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
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "edgefusion/ball.hpp"
#include "edgefusion/disjoint_sets.hpp"
#include "edgefusion/grid.hpp"
#include "edgefusion/neighbourhood.hpp"
#include "edgefusion/touch.hpp"

namespace edgefusion {
namespace {

template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  throw std::invalid_argument(text.str());
}

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
        core_end_(grid_.cell_count()),
        clusters_(grid_.cell_count()) {}

  void label(std::int32_t* labels) {
    find_clusters();
    number_clusters(labels);
    label_borders(labels);
  }

 private:
  bool has_core(std::uint32_t cell) const { return core_end_[cell] > grid_.begin[cell]; }
  bool has_border(std::uint32_t cell) const { return core_end_[cell] < grid_.begin[cell + 1]; }

  PointRange cores(std::uint32_t cell) const { return {grid_.begin[cell], core_end_[cell]}; }

  bool has_core(const Neighbourhood& near) const {
    for (const Span& span : near)
      for (std::uint32_t cell = span.begin; cell < span.end; ++cell)
        if (has_core(cell)) return true;
    return false;
  }

  void find_clusters() {
    Neighbourhood near(grid_);
    for (std::uint32_t cell = 0; cell < grid_.cell_count(); ++cell) {
      near.slide_to(cell);
      find_cores(cell, near);
      if (has_core(cell)) connect_to_earlier(cell, near);
    }
  }

  // Moves the core points of a cell to its front.
  void find_cores(std::uint32_t cell, const Neighbourhood& near) {
    const std::uint32_t end = grid_.begin[cell + 1];
    std::uint32_t& core_end = core_end_[cell];
    core_end = grid_.begin[cell];
    if (grid_.size(cell) >= min_points_) {
      core_end = end;
    } else if (can_have_core(near)) {
      for (std::uint32_t point = core_end; point < end; ++point)
        if (is_core(point, near)) swap_points(point, core_end++);
    }
  }

  bool can_have_core(const Neighbourhood& near) const {
    std::uint32_t points = 0;
    for (const Span& span : near) points += grid_.begin[span.end] - grid_.begin[span.begin];
    return points >= min_points_;
  }

  bool is_core(std::uint32_t point, const Neighbourhood& near) const {
    std::uint32_t count = 0;
    for (const Span& span : near) {
      count += count_reached(point, grid_.begin[span.begin], grid_.begin[span.end], min_points_ - count);
      if (count >= min_points_) return true;
    }
    return false;
  }

  // Stops soon after `enough`. Four at a time and no branch for each: a span of a sparse grid has about two
  // points.
  std::uint32_t count_reached(std::uint32_t point, std::uint32_t begin, std::uint32_t end,
                              std::uint32_t enough) const {
    std::uint32_t count = 0;
    for (; begin < end && count < enough; begin += 4)
      for (std::uint32_t i = 0; i < 4; ++i) count += reaches(point, begin + i) & (i < end - begin);
    return count;
  }

  bool reaches(std::uint32_t a, std::uint32_t b) const {
    return ball_.reaches(grid_.x[b] - grid_.x[a], grid_.y[b] - grid_.y[a]);
  }

  void swap_points(std::uint32_t a, std::uint32_t b) {
    std::swap(grid_.x[a], grid_.x[b]);
    std::swap(grid_.y[a], grid_.y[b]);
    std::swap(grid_.index[a], grid_.index[b]);
  }

  // Each pair of cells is connected once, when the later one is visited: the cores of the earlier are known
  // by then.
  void connect_to_earlier(std::uint32_t cell, const Neighbourhood& near) {
    std::uint32_t root = cell;
    for (const Span& span : near) {
      for (std::uint32_t other = span.begin; other < std::min(span.end, cell); ++other) {
        if (!has_core(other)) continue;
        const std::uint32_t other_root = clusters_.find(other);
        if (other_root != root && touch(grid_, ball_, cores(cell), cores(other)))
          root = clusters_.join(root, other_root);
      }
    }
  }

  // In the order of the input, so that the cluster with the lowest core index comes first.
  void number_clusters(std::int32_t* labels) {
    for (std::uint32_t cell = 0; cell < grid_.cell_count(); ++cell) {
      const auto root = static_cast<std::int32_t>(clusters_.find(cell));
      for (std::uint32_t point = grid_.begin[cell]; point < grid_.begin[cell + 1]; ++point)
        labels[grid_.index[point]] = point < core_end_[cell] ? root : kNoise;
    }
    std::vector<std::int32_t> number(grid_.cell_count(), kNoise);
    std::int32_t next = 0;
    for (std::size_t i = 0; i < grid_.index.size(); ++i) {
      if (labels[i] == kNoise) continue;
      std::int32_t& of_root = number[static_cast<std::size_t>(labels[i])];
      if (of_root == kNoise) of_root = next++;
      labels[i] = of_root;
    }
  }

  // A point that is not a core joins the lowest cluster that has a core point within its reach.
  void label_borders(std::int32_t* labels) {
    std::vector<std::uint32_t> cluster(grid_.index.size() + Grid::kPadding);  // of each core point
    for (std::size_t point = 0; point < grid_.index.size(); ++point)
      cluster[point] = static_cast<std::uint32_t>(labels[grid_.index[point]]);
    Neighbourhood near(grid_);
    for (std::uint32_t cell = 0; cell < grid_.cell_count(); ++cell) {
      if (!has_border(cell)) continue;
      near.slide_to(cell);
      if (!has_core(near)) continue;
      for (std::uint32_t point = core_end_[cell]; point < grid_.begin[cell + 1]; ++point)
        labels[grid_.index[point]] = static_cast<std::int32_t>(lowest_cluster(point, near, cluster));
    }
  }

  // Unsigned, noise is the highest number of all, and what is not reached is made noise: no branch is needed.
  std::uint32_t lowest_cluster(std::uint32_t point, const Neighbourhood& near,
                               const std::vector<std::uint32_t>& cluster) const {
    auto lowest = static_cast<std::uint32_t>(kNoise);
    for (const Span& span : near) {
      const std::uint32_t end = grid_.begin[span.end];
      for (std::uint32_t begin = grid_.begin[span.begin]; begin < end; begin += 4) {
        for (std::uint32_t i = 0; i < 4; ++i) {
          const std::uint32_t reached = reaches(point, begin + i) & (i < end - begin);
          lowest = std::min(lowest, cluster[begin + i] | (reached - 1U));
        }
      }
    }
    return lowest;
  }

  Grid grid_;
  Ball ball_;
  std::uint32_t min_points_;
  std::vector<std::uint32_t> core_end_;  // of each cell: the end of its core points
  DisjointSets clusters_;                // of cells with core points
};

}  // namespace

void dbscan(const double* points, std::size_t n, double eps, int min_points, std::int32_t* labels) {
  check(points, n, eps, min_points);
  if (n == 0) return;
  Clustering(points, n, eps, static_cast<std::uint32_t>(min_points)).label(labels);
}

}  // namespace edgefusion
