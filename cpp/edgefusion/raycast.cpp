// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/raycast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

// Of the diamond angle, which is sure to a few roundings.
constexpr double kTurn = 4.0, kHalfTurn = 2.0, kMargin = 1e-9;
// Beams that are 0.5 degrees apart over half a turn then have two buckets each.
constexpr std::size_t kBucketsPerBeam = 4;

struct Point {
  double x, y;
};

struct Beam {
  double x, y;  // its direction, of length 1
  double range;
  std::int32_t hit;
  std::uint32_t index;
};

// Rises from 0 to kTurn as the angle does from 0 to 2 pi, without its cost: the place on |x| + |y| = 1.
double diamond_angle(double x, double y) {
  const double height = y / (std::abs(x) + std::abs(y));
  if (x < 0.0) return kHalfTurn - height;
  return height < 0.0 ? kTurn + height : height;
}

// Squared distance to the smallest upright rectangle about a segment, never more than that to the segment.
double squared_distance(const Point& a, const Point& b) {
  const double x = std::max({0.0, std::min(a.x, b.x), -std::max(a.x, b.x)});
  const double y = std::max({0.0, std::min(a.y, b.y), -std::max(a.y, b.y)});
  return x * x + y * y;
}

// Range at which a beam meets the segment from a to b, or infinity. An end is left or right of a beam
// whichever segment it belongs to, since the same numbers are multiplied.
double meeting(const Beam& beam, const Point& a, const Point& b) {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  const double left_a = beam.x * a.y - beam.y * a.x, left_b = beam.x * b.y - beam.y * b.x;
  if ((left_a > 0.0 && left_b > 0.0) || (left_a < 0.0 && left_b < 0.0)) return kNowhere;
  const double along_a = beam.x * a.x + beam.y * a.y, along_b = beam.x * b.x + beam.y * b.y;
  double range = along_a + (along_b - along_a) * (left_a / (left_a - left_b));
  if (left_a == left_b) range = (along_a > 0.0) != (along_b > 0.0) ? 0.0 : std::min(along_a, along_b);
  return range >= 0.0 ? range : kNowhere;
}

// The beams of a sweep in buckets of their diamond angle, so that those between two angles are found at once.
class Fan {
 public:
  Fan(double theta, const Sweep& sweep)
      : beams_(sweep.n),
        begin_(kBucketsPerBeam * sweep.n + 2),
        range_max_(sweep.range_max),
        per_angle_(static_cast<double>(kBucketsPerBeam * sweep.n) / kTurn) {
    std::vector<Beam> unsorted(sweep.n);
    for (std::size_t i = 0; i < sweep.n; ++i) {
      const double angle = theta + (sweep.angle_min + static_cast<double>(i) * sweep.angle_increment);
      unsorted[i] = {std::cos(angle), std::sin(angle), std::numeric_limits<double>::infinity(), kNoHit,
                     static_cast<std::uint32_t>(i)};
    }
    sort(unsorted);
  }

  void cast(std::int32_t row, const Point& a, const Point& b) {
    const double from = diamond_angle(a.x, a.y), to = diamond_angle(b.x, b.y);
    const double low = std::min(from, to), high = std::max(from, to), span = std::abs(to - from);
    if (span < kHalfTurn - kMargin) {
      cast_between(low - kMargin, high + kMargin, row, a, b);
    } else if (span > kHalfTurn + kMargin) {
      cast_between(high - kMargin, low + kTurn + kMargin, row, a, b);
    } else {  // the laser is on the segment or nearly so, or on one of its ends, which has no angle (NaN)
      cast_between(0.0, kTurn, row, a, b);
    }
  }

  void write(double* ranges, std::int32_t* hits) const {
    for (const Beam& beam : beams_) {
      ranges[beam.index] = beam.range;
      hits[beam.index] = beam.hit;
    }
  }

 private:
  std::size_t bucket(double angle) const { return static_cast<std::size_t>(angle * per_angle_); }

  void sort(const std::vector<Beam>& unsorted) {
    std::vector<std::size_t> buckets(unsorted.size());
    for (std::size_t i = 0; i < unsorted.size(); ++i) {
      buckets[i] = bucket(diamond_angle(unsorted[i].x, unsorted[i].y));
      ++begin_[buckets[i]];
    }
    std::uint32_t end = 0;
    for (std::uint32_t& begin : begin_) begin = end += begin;
    for (std::size_t i = unsorted.size(); i-- > 0;) beams_[--begin_[buckets[i]]] = unsorted[i];
  }

  void cast_between(double from, double to, std::int32_t row, const Point& a, const Point& b) {
    if (from < 0.0) cast_within(from + kTurn, kTurn, row, a, b);
    if (to > kTurn) cast_within(0.0, to - kTurn, row, a, b);
    cast_within(std::max(from, 0.0), std::min(to, kTurn), row, a, b);
  }

  void cast_within(double from, double to, std::int32_t row, const Point& a, const Point& b) {
    const std::size_t end = begin_[bucket(to) + 1];
    for (std::size_t i = begin_[bucket(from)]; i < end; ++i) {
      const double range = meeting(beams_[i], a, b);
      if (range < beams_[i].range && range <= range_max_) {
        beams_[i].range = range;
        beams_[i].hit = row;
      }
    }
  }

  std::vector<Beam> beams_;
  std::vector<std::uint32_t> begin_;  // of each bucket in beams_, and behind the last one
  double range_max_;
  double per_angle_;
};

void check(const double* segments, std::size_t m, const LaserPose& pose, const Sweep& sweep) {
  expect_finite("segments", segments, 4 * m);
  const double values[] = {pose.x, pose.y, pose.theta};
  expect_finite("pose", values, 3);
  if (!std::isfinite(sweep.angle_min)) refuse("angle_min: expected a finite number, got ", sweep.angle_min);
  if (!std::isfinite(sweep.angle_increment) || sweep.angle_increment == 0.0)
    refuse("angle_increment: expected a finite number other than 0, got ", sweep.angle_increment);
  const double last = pose.theta + (sweep.angle_min + static_cast<double>(sweep.n) * sweep.angle_increment);
  if (!std::isfinite(last)) refuse("angle_increment: expected finite angles of all beams, got ", last);
  if (!(sweep.range_max > 0.0 && std::isfinite(sweep.range_max)))
    refuse("range_max: expected a finite number above 0, got ", sweep.range_max);
}

}  // namespace

void raycast(const double* segments, std::size_t m, const LaserPose& pose, const Sweep& sweep, double* ranges,
             std::int32_t* hits) {
  check(segments, m, pose, sweep);
  Fan fan(pose.theta, sweep);
  const double reach = sweep.range_max * (1.0 + kMargin);
  for (std::size_t row = 0; row < m; ++row) {
    const double* s = segments + 4 * row;
    const Point a{s[0] - pose.x, s[1] - pose.y}, b{s[2] - pose.x, s[3] - pose.y};
    const bool is_point = a.x == b.x && a.y == b.y;
    if (is_point || squared_distance(a, b) > reach * reach) continue;
    fan.cast(static_cast<std::int32_t>(row), a, b);
  }
  fan.write(ranges, hits);
}

}  // namespace edgefusion
