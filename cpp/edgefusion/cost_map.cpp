// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/cost_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

// Of a cell near which nothing is, and where the base cannot be.
constexpr float kNoPoint = std::numeric_limits<float>::infinity(), kNever = kNoPoint;
// Seen once, a point stops the base but shuts no way: a beam that lies on two surfaces may have made it up.
constexpr int kConfirmed = 2;
// What a metre costs more where the base failed once to get through.
constexpr double kAvoided = 10.0;

}  // namespace

CostMap::CostMap(const WayCost& cost) : cost_(cost) {
  const std::pair<const char*, double> all[] = {
      {"blocked", cost.blocked}, {"comfort", cost.comfort}, {"weight", cost.weight}};
  for (const auto& [name, value] : all)
    if (!(value >= 0.0 && std::isfinite(value)))
      refuse(name, ": expected a finite number of at least 0, got ", value);
  if (!(cost.comfort > cost.blocked))
    refuse("comfort: expected more than blocked, ", cost.blocked, ", got ", cost.comfort);
}

void CostMap::begin(const ObstacleMap& map) {
  window_ = map.window();
  cell_ = map.cell();
  nearest_.resize(window_.size());
  avoided_.resize(window_.size());
  row_ = 0;
  stage_ = Stage::kUpwards;
}

std::size_t CostMap::advance(const ObstacleMap& map, std::size_t cells) {
  std::size_t worked = 0;
  if (stage_ == Stage::kUpwards) worked = sweep_upwards(map, cells);
  if (stage_ == Stage::kDownwards && worked < cells) worked += sweep_downwards(cells - worked);
  return worked;
}

// The nearest point of a cell is that of a neighbour, if any is near (Danielsson 1980): two sweeps over all cells find
// it, the first from the lowest row upwards.
bool CostMap::take(std::size_t to, std::size_t from, double x, double y) {
  const Point point = nearest_[from];
  if (point.x == kNoPoint) return false;
  const auto apart = [x, y](const Point& p) {
    const double dx = static_cast<double>(p.x) - x, dy = static_cast<double>(p.y) - y;
    return dx * dx + dy * dy;
  };
  const double squared = apart(point);
  // A little farther than it counts: a cell's nearest point comes to it through its neighbours.
  const double farthest = cost_.comfort + 2.0 * cell_;
  if (squared > farthest * farthest) return false;
  Point& own = nearest_[to];
  if (own.x != kNoPoint && apart(own) <= squared) return false;
  own = point;
  return true;
}

void CostMap::read_row(const ObstacleMap& map) {
  const auto columns = static_cast<std::size_t>(window_.columns);
  const std::size_t first = static_cast<std::size_t>(row_) * columns;
  for (std::size_t i = first; i < first + columns; ++i) {
    const ObstacleMap::Cell& cell = map.at(i);
    avoided_[i] = cell.avoided;
    nearest_[i] =
        cell.evidence > 0 && cell.points >= kConfirmed ? Point{cell.x, cell.y} : Point{kNoPoint, kNoPoint};
  }
}

std::size_t CostMap::sweep_upwards(const ObstacleMap& map, std::size_t cells) {
  const MapWindow& w = window_;
  const auto columns = static_cast<std::size_t>(w.columns);
  std::size_t done = 0;
  for (; row_ < w.rows && done < cells; ++row_, done += columns) {
    const std::size_t first = static_cast<std::size_t>(row_) * columns;
    const double y = middle(w.row + row_);
    read_row(map);
    for (std::size_t c = 0; c < columns; ++c) {
      const std::size_t i = first + c;
      const double x = middle(w.column + static_cast<std::int32_t>(c));
      if (c > 0) take(i, i - 1, x, y);
      if (row_ == 0) continue;
      take(i, i - columns, x, y);
      if (c > 0) take(i, i - columns - 1, x, y);
      if (c + 1 < columns) take(i, i - columns + 1, x, y);
    }
    for (std::size_t c = columns - 1; c-- > 0;)
      take(first + c, first + c + 1, middle(w.column + static_cast<std::int32_t>(c)), y);
  }
  if (row_ == w.rows) {
    stage_ = Stage::kDownwards;
    row_ = w.rows - 1;
  }
  return done;
}

std::size_t CostMap::sweep_downwards(std::size_t cells) {
  const MapWindow& w = window_;
  const auto columns = static_cast<std::size_t>(w.columns);
  std::size_t done = 0;
  for (; row_ >= 0 && done < cells; --row_, done += columns) {
    const std::size_t first = static_cast<std::size_t>(row_) * columns;
    const double y = middle(w.row + row_);
    for (std::size_t c = columns; c-- > 0;) {
      const std::size_t i = first + c;
      const double x = middle(w.column + static_cast<std::int32_t>(c));
      if (c + 1 < columns) take(i, i + 1, x, y);
      if (row_ + 1 == w.rows) continue;
      take(i, i + columns, x, y);
      if (c > 0) take(i, i + columns - 1, x, y);
      if (c + 1 < columns) take(i, i + columns + 1, x, y);
    }
    for (std::size_t c = 1; c < columns; ++c)
      take(first + c, first + c - 1, middle(w.column + static_cast<std::int32_t>(c)), y);
  }
  if (row_ < 0) stage_ = Stage::kDone;
  return done;
}

float CostMap::at(std::size_t index, std::int32_t column, std::int32_t row) const {
  const Point& point = nearest_[index];
  const double failed = kAvoided * static_cast<double>(avoided_[index]);
  if (point.x == kNoPoint) return static_cast<float>(1.0 + failed);
  const double apart =
      std::hypot(static_cast<double>(point.x) - middle(column), static_cast<double>(point.y) - middle(row));
  if (apart < cost_.blocked) return kNever;
  const double near = (cost_.comfort - apart) / (cost_.comfort - cost_.blocked);
  return static_cast<float>(1.0 + failed + (near <= 0.0 ? 0.0 : cost_.weight * near * near));
}

}  // namespace edgefusion
