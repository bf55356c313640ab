// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/split.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "edgefusion/dbscan.hpp"
#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

// In sigma: how far a point of a face lies off its line at most; how much nearer another thing is at least; the root
// mean square of a straight face. Chosen on simulated scans of random worlds, as is what follows.
constexpr double kOnLine = 3.0, kNearer = 6.0, kStraight = 2.0;
// A face: so many points over so many metres.
constexpr std::size_t kFacePoints = 8;
constexpr double kFaceLength = 0.2;
// A run grows until it stays as it is, over single points that are off.
constexpr int kGrowths = 6;
constexpr std::size_t kSkipped = 2;
constexpr int kDeepest = 6;

struct Point {
  double x, y;
};

// The points at distance `offset` along the unit normal, which looks at the laser.
struct Line {
  double normal_x, normal_y, offset;

  // Above 0: nearer to the laser than the line.
  double nearer(const Point& p) const { return normal_x * p.x + normal_y * p.y - offset; }
  double along(const Point& p) const { return normal_x * p.y - normal_y * p.x; }
};

struct Run {
  std::size_t begin, end;
};

struct Face {
  Line line;
  double length;
  std::size_t end;  // behind its last point
};

// Total least squares.
Line fitted(const std::vector<Point>& points, const Run& run) {
  const auto n = static_cast<double>(run.end - run.begin);
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t i = run.begin; i < run.end; ++i) {
    x += points[i].x / n;
    y += points[i].y / n;
  }
  for (std::size_t i = run.begin; i < run.end; ++i) {
    const double dx = points[i].x - x, dy = points[i].y - y;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  }
  const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  const double nx = -std::sin(angle), ny = std::cos(angle), offset = nx * x + ny * y;
  return offset > 0.0 ? Line{-nx, -ny, -offset} : Line{nx, ny, offset};
}

class Splitter {
 public:
  explicit Splitter(const SplitRule& rule) : rule_(rule) {}

  // Calls `found` with the rows of every cluster that `rows` falls into.
  template <typename Found>
  void split(const std::vector<Point>& points, const std::vector<std::size_t>& rows, int depth,
             Found&& found) {
    const std::optional<Face> face = depth < kDeepest ? face_behind_something(points) : std::nullopt;
    if (!face) {
      found(rows);
      return;
    }
    std::vector<std::size_t> on_face, rest_rows;
    std::vector<Point> rest;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (std::abs(face->line.nearer(points[i])) <= kOnLine * rule_.sigma_m) {
        on_face.push_back(rows[i]);
      } else {
        rest.push_back(points[i]);
        rest_rows.push_back(rows[i]);
      }
    }
    found(on_face);
    std::vector<std::int32_t> labels(rest.size());
    dbscan(&rest.data()->x, rest.size(), rule_.eps, rule_.min_points, labels.data());
    const std::int32_t clusters = 1 + *std::max_element(labels.begin(), labels.end());
    for (std::int32_t cluster = 0; cluster < clusters; ++cluster) {
      std::vector<Point> part;
      std::vector<std::size_t> part_rows;
      for (std::size_t i = 0; i < rest.size(); ++i) {
        if (labels[i] != cluster) continue;
        part.push_back(rest[i]);
        part_rows.push_back(rest_rows[i]);
      }
      split(part, part_rows, depth + 1, found);
    }
  }

 private:
  // The longest straight face that something stands before.
  std::optional<Face> face_behind_something(const std::vector<Point>& points) const {
    std::optional<Face> longest;
    if (points.size() < kFacePoints + static_cast<std::size_t>(rule_.min_points)) return longest;
    for (std::size_t i = 0; i + kFacePoints <= points.size();) {
      const std::optional<Face> face = face_around(points, {i, i + kFacePoints});
      if (face && (!longest || face->length > longest->length) && something_before(points, face->line))
        longest = face;
      i += kFacePoints / 2;
      if (face)
        i = std::max(i, face->end - std::min(face->end, kFacePoints / 2));  // from within it grows again
    }
    return longest;
  }

  bool something_before(const std::vector<Point>& points, const Line& line) const {
    const auto nearer = std::count_if(points.begin(), points.end(), [&](const Point& p) {
      return line.nearer(p) > kNearer * rule_.sigma_m;
    });
    return nearer >= rule_.min_points;
  }

  std::optional<Face> face_around(const std::vector<Point>& points, Run run) const {
    for (int growth = 0; growth < kGrowths; ++growth) {
      const Run before = run;
      if (!grow(points, fitted(points, run), run)) return std::nullopt;
      if (run.begin == before.begin && run.end == before.end) break;
    }
    if (run.end - run.begin < kFacePoints) return std::nullopt;
    const Line line = fitted(points, run);
    double squares = 0.0, count = 0.0, low = 0.0, high = 0.0;
    for (std::size_t i = run.begin; i < run.end; ++i) {
      if (!on(line, points[i])) continue;
      const double off = line.nearer(points[i]), along = line.along(points[i]);
      low = count == 0.0 ? along : std::min(low, along);
      high = count == 0.0 ? along : std::max(high, along);
      squares += off * off;
      count += 1.0;
    }
    const bool straight = squares <= count * kStraight * kStraight * rule_.sigma_m * rule_.sigma_m;
    if (!straight || high - low < kFaceLength) return std::nullopt;
    return Face{line, high - low, run.end};
  }

  bool on(const Line& line, const Point& p) const {
    return std::abs(line.nearer(p)) <= kOnLine * rule_.sigma_m;
  }

  // From the first to the last point of the run that lies on the line, then outwards as long as points do.
  bool grow(const std::vector<Point>& points, const Line& line, Run& run) const {
    while (run.begin < run.end && !on(line, points[run.begin])) ++run.begin;
    while (run.end > run.begin && !on(line, points[run.end - 1])) --run.end;
    if (run.end - run.begin < kFacePoints / 2) return false;
    for (std::size_t i = run.begin, off = 0; i-- > 0 && off < kSkipped;) {
      off = on(line, points[i]) ? 0 : off + 1;
      if (off == 0) run.begin = i;
    }
    for (std::size_t i = run.end, off = 0; i < points.size() && off < kSkipped; ++i) {
      off = on(line, points[i]) ? 0 : off + 1;
      if (off == 0) run.end = i + 1;
    }
    return true;
  }

  const SplitRule& rule_;
};

void check(const double* points, std::size_t n, const SplitRule& rule, const std::int32_t* labels) {
  expect_finite("points", points, 2 * n);
  for (const auto& [name, value] : {std::pair{"sigma_m", rule.sigma_m}, std::pair{"eps", rule.eps}})
    if (!(value > 0.0 && std::isfinite(value)))
      refuse(name, ": expected a finite number above 0, got ", value);
  if (rule.min_points < 1) refuse("min_points: expected at least 1, got ", rule.min_points);
  for (std::size_t i = 0; i < n; ++i)
    if (labels[i] < kNoise || labels[i] >= static_cast<std::int64_t>(n))
      refuse("labels: expected -1 to ", static_cast<std::int64_t>(n) - 1, ", got ", labels[i], " at index ",
             i);
}

}  // namespace

void split_clusters(const double* points, std::size_t n, const SplitRule& rule, std::int32_t* labels) {
  check(points, n, rule, labels);
  std::int32_t clusters = n ? 1 + *std::max_element(labels, labels + n) : 0;
  std::vector<std::vector<std::size_t>> members(static_cast<std::size_t>(clusters));
  for (std::size_t i = 0; i < n; ++i)
    if (labels[i] != kNoise) members[static_cast<std::size_t>(labels[i])].push_back(i);

  Splitter splitter(rule);
  for (std::size_t cluster = 0; cluster < members.size(); ++cluster) {
    std::vector<Point> own;
    for (const std::size_t row : members[cluster]) {
      own.push_back({points[2 * row], points[2 * row + 1]});
      labels[row] = kNoise;  // what no part takes, as what lies alone before a face
    }
    bool first = true;
    splitter.split(own, members[cluster], 0, [&](const std::vector<std::size_t>& part) {
      const std::int32_t label = first ? static_cast<std::int32_t>(cluster) : clusters++;
      for (const std::size_t row : part) labels[row] = label;
      first = false;
    });
  }
}

}  // namespace edgefusion
