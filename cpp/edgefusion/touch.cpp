// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/touch.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace edgefusion {
namespace {

// Up to here, trying all pairs is faster than splitting.
constexpr std::size_t kFewPairs = 1024;

bool touch_directly(const Points& points, const Ball& ball, PointRange a, PointRange b) {
  for (std::uint32_t i = a.begin; i < a.end; ++i)
    for (std::uint32_t j = b.begin; j < b.end; ++j)
      if (ball.reaches(points.x[i] - points.x[j], points.y[i] - points.y[j])) return true;
  return false;
}

struct Bounds {
  double low_x, high_x, low_y, high_y;
};

// Two crowds may face each other along a curved gap: then neither a lucky pair nor their bounding boxes
// decide, and all pairs would be quadratic. Halving the larger one again and again leaves only the pairs near
// the gap.
class Halving {
 public:
  using Point = std::vector<std::uint32_t>::iterator;

  Halving(const Points& points, const Ball& ball) : points_(points), ball_(ball) {}

  bool touch(Point a, Point a_end, Point b, Point b_end) const {
    if (reaches(*a, *b)) return true;
    const auto pairs = static_cast<std::size_t>(a_end - a) * static_cast<std::size_t>(b_end - b);
    if (pairs <= kFewPairs) return any_pair(a, a_end, b, b_end);
    const Bounds bounds_a = bounds(a, a_end);
    const Bounds bounds_b = bounds(b, b_end);
    if (apart(bounds_a, bounds_b)) return false;
    if (a_end - a < b_end - b) return touch_halves(b, b_end, bounds_b, a, a_end);
    return touch_halves(a, a_end, bounds_a, b, b_end);
  }

 private:
  bool reaches(std::uint32_t i, std::uint32_t j) const {
    return ball_.reaches(points_.x[i] - points_.x[j], points_.y[i] - points_.y[j]);
  }

  bool any_pair(Point a, Point a_end, Point b, Point b_end) const {
    return std::any_of(a, a_end, [&](std::uint32_t i) {
      return std::any_of(b, b_end, [&](std::uint32_t j) { return reaches(i, j); });
    });
  }

  bool touch_halves(Point a, Point a_end, const Bounds& wide, Point b, Point b_end) const {
    const bool along_x = wide.high_x - wide.low_x > wide.high_y - wide.low_y;
    const std::vector<double>& value = along_x ? points_.x : points_.y;
    const Point middle = a + (a_end - a) / 2;
    std::nth_element(a, middle, a_end, [&](std::uint32_t i, std::uint32_t j) { return value[i] < value[j]; });
    return touch(a, middle, b, b_end) || touch(middle, a_end, b, b_end);
  }

  Bounds bounds(Point a, Point a_end) const {
    Bounds box{points_.x[*a], points_.x[*a], points_.y[*a], points_.y[*a]};
    for (; a < a_end; ++a) {
      box.low_x = std::min(box.low_x, points_.x[*a]);
      box.high_x = std::max(box.high_x, points_.x[*a]);
      box.low_y = std::min(box.low_y, points_.y[*a]);
      box.high_y = std::max(box.high_y, points_.y[*a]);
    }
    return box;
  }

  // Rounding is monotonic: where the nearest corners do not reach each other, no points in the boxes do.
  bool apart(const Bounds& a, const Bounds& b) const {
    const double gap_x = std::max({0.0, a.low_x - b.high_x, b.low_x - a.high_x});
    const double gap_y = std::max({0.0, a.low_y - b.high_y, b.low_y - a.high_y});
    return !ball_.reaches(gap_x, gap_y);
  }

  const Points& points_;
  const Ball& ball_;
};

std::vector<std::uint32_t> points_of(PointRange range) {
  std::vector<std::uint32_t> points(range.end - range.begin);
  std::iota(points.begin(), points.end(), range.begin);
  return points;
}

}  // namespace

bool touch(const Points& points, const Ball& ball, PointRange a, PointRange b) {
  if (std::size_t{a.end - a.begin} * (b.end - b.begin) <= kFewPairs)
    return touch_directly(points, ball, a, b);
  std::vector<std::uint32_t> points_a = points_of(a);
  std::vector<std::uint32_t> points_b = points_of(b);
  return Halving(points, ball).touch(points_a.begin(), points_a.end(), points_b.begin(), points_b.end());
}

}  // namespace edgefusion
