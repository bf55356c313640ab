// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/obstacle_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "edgefusion/cells.hpp"
#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

constexpr double kLargestSide = 60.0, kAround = 5.0, kSmallestCell = 0.01;

// A beam that ends in a cell weighs as much as three that come through; what was seen for long fades in a dozen.
constexpr int kHit = 3, kStrongest = 12;
constexpr int kMeanOf = 12;
// A point that one beam gave may be off by this [m], the mean of many by less; farther apart, two cells' points are
// different things.
constexpr double kNoise = 0.035;
// How much of a cell's reach each further beam lets it forget.
constexpr float kForget = 1.0f / 64;
// Beams that end so near to the outermost one, in metres and as a part of all the reach, are the outermost few, and each
// of them counts so much.
constexpr double kEnd = 0.006, kEndPart = 0.15, kEndShare = 0.25;
// Ends nearer to the mean than this say nothing new [m].
constexpr double kApart = 0.005;
constexpr std::uint8_t kMostHits = 100;
// A beam that passes farther from the point than this says nothing about it: it may be a wall that the beam grazes.
constexpr double kThrough = 0.02;
// So many beams must have come through a cell's middle before it counts as one where nothing was.
constexpr std::uint8_t kPassed = 4;
// Beams are followed so far: beyond, they lie too far apart to say what is free.
constexpr double kFollowed = 10.0;
// Nothing is said about the last stretch before the point that a beam ended at [m].
constexpr double kBeforeHit = 0.08;

void expect_sweep(const LaserScan& scan) {
  expect_finite("poses", scan.poses, 3 * scan.n);
  for (std::size_t i = 0; i < scan.n; ++i) expect_on_map("poses", scan.poses + 3 * i, 2);
  const double angles[] = {scan.angle_min, scan.angle_increment};
  expect_finite("angle_min, angle_increment", angles, 2);
  if (!(scan.range_min >= 0.0 && std::isfinite(scan.range_min)))
    refuse("range_min: expected a finite number of at least 0, got ", scan.range_min);
  if (!(scan.range_max > scan.range_min))
    refuse("range_max: expected more than range_min, ", scan.range_min, ", got ", scan.range_max);
}

}  // namespace

ObstacleMap::ObstacleMap(double cell) : cell_(cell) {
  if (!(cell >= kSmallestCell && std::isfinite(cell)))
    refuse("cell: expected a finite number of at least ", kSmallestCell, ", got ", cell);
}

std::int32_t ObstacleMap::column_of(double coordinate) const {
  return floored(coordinate / cell_);
}

void ObstacleMap::cover(double x, double y, double target_x, double target_y) {
  const double given[] = {x, y, target_x, target_y};
  expect_on_map("base, target", given, 4);
  const auto cells = [this](double metres) { return static_cast<std::int32_t>(std::ceil(metres / cell_)); };
  const std::int32_t around = cells(kAround), largest = cells(kLargestSide);
  const auto span = [&](std::int32_t begin, std::int32_t size, std::int32_t base, std::int32_t target) {
    std::int32_t low = std::min(base, target) - around, high = std::max(base, target) + around + 1;
    if (size > 0 && low >= begin && high <= begin + size) return std::pair(begin, size);
    const std::int32_t room = std::max(0, (largest - (high - low)) / 2);
    const std::int32_t slack = std::min(around / 2, room);  // does not grow, or move, at every step
    low -= slack;
    high += slack;
    // What there is already, too, as far as it fits.
    const std::int32_t first_of_all = size > 0 ? std::min(low, begin) : low;
    const std::int32_t last_of_all = size > 0 ? std::max(high, begin + size) : high;
    if (last_of_all - first_of_all <= largest) return std::pair(first_of_all, last_of_all - first_of_all);
    if (high - low <= largest) return std::pair(std::clamp(begin, high - largest, low), largest);
    const bool inside = size == largest && base - around >= begin && base + around < begin + size;
    if (inside) return std::pair(begin, size);
    const std::int32_t first = base - largest / 2;
    return std::pair(first, largest);
  };
  const auto [column, columns] = span(window_.column, window_.columns, column_of(x), column_of(target_x));
  const auto [row, rows] = span(window_.row, window_.rows, column_of(y), column_of(target_y));
  const MapWindow window{column, row, columns, rows};
  if (!(window == window_)) resize(window);
}

void ObstacleMap::resize(const MapWindow& window) {
  std::vector<Cell> cells(window.size());
  const std::int32_t first = std::max(window.column, window_.column);
  const std::int32_t last = std::min(window.column + window.columns, window_.column + window_.columns);
  const std::int32_t bottom = std::max(window.row, window_.row);
  const std::int32_t top = std::min(window.row + window.rows, window_.row + window_.rows);
  if (first < last)
    for (std::int32_t r = bottom; r < top; ++r)
      std::copy_n(cells_.begin() + static_cast<std::ptrdiff_t>(window_.index(first, r)), last - first,
                  cells.begin() + static_cast<std::ptrdiff_t>(window.index(first, r)));
  cells_ = std::move(cells);
  window_ = window;
}

void ObstacleMap::insert(const LaserScan& scan, std::uint32_t now_ms) {
  expect_sweep(scan);
  // Beams first come through, then end: what they end at is not let fade by their own neighbours.
  for (std::size_t i = 0; i < scan.n; ++i) {
    const double range = static_cast<double>(scan.ranges[i]);
    if (std::isnan(range) || range < scan.range_min) continue;
    const double free = std::min({kFollowed, range - kBeforeHit, scan.range_max});
    const double angle =
        scan.poses[3 * i + 2] + scan.angle_min + scan.angle_increment * static_cast<double>(i);
    trace(scan.poses[3 * i], scan.poses[3 * i + 1], std::cos(angle), std::sin(angle), free);
  }
  for (std::size_t i = 0; i < scan.n; ++i) {
    double range = static_cast<double>(scan.ranges[i]);
    if (std::isnan(range) || range == std::numeric_limits<double>::infinity() || range > scan.range_max)
      continue;
    range = std::max(range, scan.range_min);  // nearer than that is as near as that
    const double angle =
        scan.poses[3 * i + 2] + scan.angle_min + scan.angle_increment * static_cast<double>(i);
    const double dx = std::cos(angle), dy = std::sin(angle);
    hit(scan.poses[3 * i] + range * dx, scan.poses[3 * i + 1] + range * dy, dx, dy, now_ms);
  }
}

void ObstacleMap::hit(double x, double y, double dx, double dy, std::uint32_t now_ms) {
  const std::int32_t c = column_of(x), r = column_of(y);
  if (!window_.holds(c, r)) return;
  Cell& cell = cells_[window_.index(c, r)];
  if (cell.evidence == 0) {
    cell.points = cell.hits = 0;
    cell.born = cell.passed >= kPassed;
    cell.passed = 0;
    cell.born_ms = now_ms;
  }
  cell.points = static_cast<std::uint8_t>(std::min<int>(cell.points + 1, kMeanOf));
  const float share = 1.0f / static_cast<float>(cell.points);
  cell.x += share * (static_cast<float>(x) - cell.x);
  cell.y += share * (static_cast<float>(y) - cell.y);
  stretch(cell, x, y, dx, dy);
  cell.evidence = static_cast<std::uint8_t>(std::min<int>(cell.evidence + kHit, kStrongest));
  cell.seen = 1;
  count(c, r);
}

// How far the points reach to either side of the beam (dx, dy): there they are exact, along the beam the mean of the
// outermost few counts. What is not seen again is slowly forgotten.
void ObstacleMap::stretch(Cell& cell, double x, double y, double dx, double dy) {
  if (cell.points == 1) {
    cell.left = cell.right = {cell.x, cell.y};
    return;
  }
  const auto across = [&](double px, double py) { return py * dx - px * dy; };
  const auto forget = [&](End& end) {
    end.x += kForget * (cell.x - end.x);
    end.y += kForget * (cell.y - end.y);
    return across(static_cast<double>(end.x), static_cast<double>(end.y));
  };
  double left = forget(cell.left), right = forget(cell.right);
  if (left < right) {  // seen from behind
    std::swap(cell.left, cell.right);
    std::swap(left, right);
  }
  const double at = across(x, y);
  const auto reach = [&](End& end, double edge) {
    const double ahead = static_cast<double>(end.x) * dx + static_cast<double>(end.y) * dy;
    const double along = ahead + kEndShare * (x * dx + y * dy - ahead);
    end.x = static_cast<float>(along * dx - edge * dy);
    end.y = static_cast<float>(along * dy + edge * dx);
  };
  const double few = std::min(kEnd, kEndPart * (left - right));  // hardly any across a beam that grazes
  if (at > left - few) reach(cell.left, std::max(at, left));
  if (at < right + few) reach(cell.right, std::min(at, right));
}

// All around is halved together, so that the shares stay, and what comes new is soon noticed.
void ObstacleMap::count(std::int32_t column, std::int32_t row) {
  if (++cells_[window_.index(column, row)].hits < kMostHits) return;
  for (std::int32_t r = row - 1; r <= row + 1; ++r)
    for (std::int32_t c = column - 1; c <= column + 1; ++c)
      if (window_.holds(c, r)) cells_[window_.index(c, r)].hits /= 2;
}

// From a point straight to the surface that a cell shows, nothing where it is farther off than noise reaches.
ObstacleMap::Point ObstacleMap::to_surface(const Cell& cell, double x, double y) {
  double dx = static_cast<double>(cell.x) - x, dy = static_cast<double>(cell.y) - y, beside = 0.0;
  const double long_x = static_cast<double>(cell.left.x - cell.right.x);
  const double long_y = static_cast<double>(cell.left.y - cell.right.y);
  const double length = std::hypot(long_x, long_y);
  if (length > kApart) {
    const double ux = long_x / length, uy = long_y / length;
    const double along = dx * ux + dy * uy;
    const double left = along + (static_cast<double>(cell.left.x - cell.x) * ux +
                                 static_cast<double>(cell.left.y - cell.y) * uy);
    beside = std::max({0.0, -left, left - length});
    dx -= along * ux;
    dy -= along * uy;
  }
  return dx * dx + dy * dy + beside * beside <= kNoise * kNoise ? Point{dx, dy} : Point{0.0, 0.0};
}

// Where the surface is that a cell shows: noise spreads it over two cells, and which has how many of its points says
// where between their means it is. The mean of many points is not off by much, whatever is beside it: it may be a
// corner.
ObstacleMap::Point ObstacleMap::surface(std::int32_t column, std::int32_t row) const {
  const Cell& cell = cells_[window_.index(column, row)];
  const double x = static_cast<double>(cell.x), y = static_cast<double>(cell.y);
  const double hits = std::max<double>(cell.hits, cell.points);  // hits fade beside what is seen more often
  double all = hits, dx = 0.0, dy = 0.0;
  for (std::int32_t r = row - 1; r <= row + 1; ++r)
    for (std::int32_t c = column - 1; c <= column + 1; ++c) {
      if (!window_.holds(c, r)) continue;
      const Cell& other = cells_[window_.index(c, r)];
      if (other.evidence == 0 || &other == &cell) continue;
      const Point off = to_surface(other, x, y);
      if (off.x == 0.0 && off.y == 0.0) continue;
      all += other.hits;
      dx += other.hits * off.x;
      dy += other.hits * off.y;
    }
  const double shift = std::hypot(dx, dy) / all, most = kNoise / std::sqrt(hits);
  const double share = (shift > most ? most / shift : 1.0) / all;
  return {x + share * dx, y + share * dy};
}

// From cell to cell along a beam.
void ObstacleMap::trace(double x, double y, double dx, double dy, double length) {
  std::int32_t c = column_of(x), r = column_of(y);
  const std::int32_t step_c = dx > 0.0 ? 1 : -1, step_r = dy > 0.0 ? 1 : -1;
  const double never = std::numeric_limits<double>::infinity();
  const double per_c = dx == 0.0 ? never : cell_ / std::abs(dx),
               per_r = dy == 0.0 ? never : cell_ / std::abs(dy);
  double next_c = dx == 0.0 ? never : ((c + (dx > 0.0)) * cell_ - x) / dx;
  double next_r = dy == 0.0 ? never : ((r + (dy > 0.0)) * cell_ - y) / dy;
  for (double t = 0.0; t < length;) {
    if (window_.holds(c, r)) {
      Cell& cell = cells_[window_.index(c, r)];
      cell.seen = 1;
      if (cell.passed < kPassed) {
        const double px = (c + 0.5) * cell_ - x, py = (r + 0.5) * cell_ - y;
        cell.passed = static_cast<std::uint8_t>(cell.passed + (std::abs(px * dy - py * dx) <= kThrough));
      }
      if (cell.evidence > 0) {
        const double px = static_cast<double>(cell.x) - x, py = static_cast<double>(cell.y) - y;
        const double along = px * dx + py * dy;
        if (std::abs(px * dy - py * dx) <= kThrough && along > 0.0 && along < length) --cell.evidence;
      }
    }
    if (next_c < next_r) {
      t = next_c;
      next_c += per_c;
      c += step_c;
    } else {
      t = next_r;
      next_r += per_r;
      r += step_r;
    }
  }
}

template <typename Visit>
void ObstacleMap::for_cells_near(double x, double y, double reach, Visit&& visit) const {
  const std::int32_t first = std::max(column_of(x - reach), window_.column);
  const std::int32_t last = std::min(column_of(x + reach), window_.column + window_.columns - 1);
  const std::int32_t bottom = std::max(column_of(y - reach), window_.row);
  const std::int32_t top = std::min(column_of(y + reach), window_.row + window_.rows - 1);
  for (std::int32_t r = bottom; r <= top; ++r)
    for (std::int32_t c = first; c <= last; ++c) visit(window_.index(c, r), c, r);
}

void ObstacleMap::stand(const Footprint& footprint, const Pose& pose, double inset) {
  const double cosine = std::cos(pose.theta), sine = std::sin(pose.theta);
  const auto gap = [&](double x, double y) {
    const double dx = x - pose.x, dy = y - pose.y;
    return footprint.gap(cosine * dx + sine * dy, cosine * dy - sine * dx);
  };
  for_cells_near(
      pose.x, pose.y, footprint.circumscribed(), [&](std::size_t i, std::int32_t c, std::int32_t r) {
        Cell& cell = cells_[i];
        if (gap((c + 0.5) * cell_, (r + 0.5) * cell_) < 0.0) cell.seen = 1;
        if (cell.evidence > 0 && gap(static_cast<double>(cell.x), static_cast<double>(cell.y)) < -inset)
          cell.evidence = 0;
      });
}

void ObstacleMap::avoid(double x, double y, double radius) {
  const double given[] = {x, y, radius};
  expect_finite("x, y, radius", given, 3);
  for_cells_near(x, y, radius, [&](std::size_t i, std::int32_t c, std::int32_t r) {
    if (std::hypot((c + 0.5) * cell_ - x, (r + 0.5) * cell_ - y) > radius) return;
    cells_[i].avoided = static_cast<std::uint8_t>(std::min(cells_[i].avoided + 1, 255));
  });
}

void ObstacleMap::points_near(double x, double y, double reach, double depth,
                              std::vector<double>& points) const {
  const auto deep = static_cast<std::int32_t>(std::lround(depth / cell_));
  for_cells_near(x, y, reach, [&](std::size_t i, std::int32_t c, std::int32_t r) {
    const Cell& cell = cells_[i];
    if (cell.evidence > 0) {
      const Point middle = surface(c, r);
      points.insert(points.end(), {middle.x, middle.y});
      const double moved_x = middle.x - static_cast<double>(cell.x),
                   moved_y = middle.y - static_cast<double>(cell.y);
      for (const Point end : {Point{static_cast<double>(cell.left.x), static_cast<double>(cell.left.y)},
                              Point{static_cast<double>(cell.right.x), static_cast<double>(cell.right.y)}}) {
        const double dx = end.x + moved_x - middle.x, dy = end.y + moved_y - middle.y;
        if (dx * dx + dy * dy < kApart * kApart) continue;
        points.insert(points.end(), {middle.x + 0.5 * dx, middle.y + 0.5 * dy, middle.x + dx, middle.y + dy});
      }
    } else if (!cell.seen && deep > 0 && near_point(c, r, deep)) {
      points.push_back((c + 0.5) * cell_);
      points.push_back((r + 0.5) * cell_);
    }
  });
}

bool ObstacleMap::near_point(std::int32_t column, std::int32_t row, std::int32_t cells) const {
  for (std::int32_t r = row - cells; r <= row + cells; ++r)
    for (std::int32_t c = column - cells; c <= column + cells; ++c)
      if (window_.holds(c, r) && cells_[window_.index(c, r)].evidence > 0) return true;
  return false;
}

double ObstacleMap::age(double x, double y, std::uint32_t now_ms) const {
  const std::int32_t c = column_of(x), r = column_of(y);
  const double never = std::numeric_limits<double>::infinity();
  if (!window_.holds(c, r)) return never;
  const Cell& cell = cells_[window_.index(c, r)];
  return cell.evidence > 0 && cell.born ? 1e-3 * static_cast<double>(now_ms - cell.born_ms) : never;
}

bool ObstacleMap::seen(double x, double y) const {
  const std::int32_t c = column_of(x), r = column_of(y);
  return window_.holds(c, r) && cells_[window_.index(c, r)].seen;
}

}  // namespace edgefusion
