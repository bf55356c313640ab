// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/navigation_function.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "edgefusion/cells.hpp"
#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

// The marching goes on so far behind the base, for the ways that it may take from there [m].
constexpr float kBehindBase = 1.0f;
// However large the map is, its costs are swept in about so many calls: a cell of theirs takes a sixteenth of the time
// that marching through it takes.
constexpr std::size_t kCostCalls = 10;

}  // namespace

NavigationFunction::NavigationFunction(const WayCost& cost) : costs_(cost) {}

void NavigationFunction::begin(const ObstacleMap& map, double goal_x, double goal_y, double tolerance,
                               double x, double y) {
  const double given[] = {goal_x, goal_y, tolerance, x, y};
  expect_on_map("goal, tolerance, base", given, 5);
  if (tolerance < 0.0) refuse("tolerance: expected at least 0, got ", tolerance);
  next_.goal_x = goal_x;
  next_.goal_y = goal_y;
  tolerance_ = tolerance;
  base_x_ = x;
  base_y_ = y;
  restart(map);
}

void NavigationFunction::restart(const ObstacleMap& map) {
  next_.window = map.window();
  next_.cell = map.cell();
  next_.values.assign(next_.window.size(), kNever);
  settled_.assign(next_.window.size(), 0);
  heap_.clear();
  costs_.begin(map);
  stage_ = Stage::kCosts;
}

bool NavigationFunction::advance(const ObstacleMap& map, std::size_t cells) {
  if (stage_ == Stage::kIdle) return false;
  if (!(next_.window == map.window())) restart(map);
  if (stage_ == Stage::kCosts) {
    const std::size_t swept = std::max(cells, CostMap::kSweeps * next_.window.size() / kCostCalls);
    cells -= std::min(cells, costs_.advance(map, swept));
    if (costs_.done()) seed();
  }
  if (stage_ == Stage::kMarch) march(cells);
  return stage_ == Stage::kIdle;
}

void NavigationFunction::seed() {
  stage_ = Stage::kMarch;
  stop_at_ = kNever;
  const MapWindow& w = next_.window;
  w.holds(floored(next_.goal_x / next_.cell), floored(next_.goal_y / next_.cell)) ? seed_goal()
                                                                                  : seed_border();
  base_ = base_cell();
  if (heap_.empty()) finish(Outcome::kOccupied);
}

void NavigationFunction::seed_goal() {
  const MapWindow& w = next_.window;
  const double reach = std::max(tolerance_, next_.cell);
  const auto cell_of = [this](double coordinate) { return floored(coordinate / next_.cell); };
  const std::int32_t last = std::min(cell_of(next_.goal_x + reach), w.column + w.columns - 1);
  const std::int32_t top = std::min(cell_of(next_.goal_y + reach), w.row + w.rows - 1);
  for (std::int32_t r = std::max(cell_of(next_.goal_y - reach), w.row); r <= top; ++r) {
    for (std::int32_t c = std::max(cell_of(next_.goal_x - reach), w.column); c <= last; ++c) {
      const double apart = std::hypot(next_.middle(c) - next_.goal_x, next_.middle(r) - next_.goal_y);
      const float cost = costs_.at(w.index(c, r), c, r);
      if (apart <= reach && cost != kNever) offer(w.index(c, r), cost * static_cast<float>(apart));
    }
  }
}

// Beyond the border all ground is taken for free: from there it is as far as the bird flies.
void NavigationFunction::seed_border() {
  const MapWindow& w = next_.window;
  const auto at = [&](std::int32_t c, std::int32_t r) {
    if (costs_.at(w.index(c, r), c, r) != kNever)
      offer(w.index(c, r),
            static_cast<float>(std::hypot(next_.middle(c) - next_.goal_x, next_.middle(r) - next_.goal_y)));
  };
  for (std::int32_t c = w.column; c < w.column + w.columns; ++c) {
    at(c, w.row);
    at(c, w.row + w.rows - 1);
  }
  for (std::int32_t r = w.row; r < w.row + w.rows; ++r) {
    at(w.column, r);
    at(w.column + w.columns - 1, r);
  }
}

// The base may stand nearer to a point than the middle of its cell could: then it is the nearest one where it fits.
std::size_t NavigationFunction::base_cell() const {
  return nearest_cell(
      next_.window, next_.cell, base_x_, base_y_, costs_.cost().blocked + next_.cell,
      [this](std::size_t i, std::int32_t c, std::int32_t r) { return costs_.at(i, c, r) != kNever; });
}

void NavigationFunction::offer(std::size_t index, float value) {
  if (!(value < next_.values[index])) return;
  next_.values[index] = value;
  heap_.push_back({value, static_cast<std::int32_t>(index)});
  std::push_heap(heap_.begin(), heap_.end());
}

std::size_t NavigationFunction::march(std::size_t cells) {
  const MapWindow& w = next_.window;
  std::size_t done = 0;
  while (done < cells && stage_ == Stage::kMarch) {
    if (heap_.empty() || heap_.front().value > stop_at_) {
      finish(base_ < w.size() && settled_[base_] ? Outcome::kReached : Outcome::kEnclosed);
      break;
    }
    const auto index = static_cast<std::size_t>(heap_.front().index);
    std::pop_heap(heap_.begin(), heap_.end());
    heap_.pop_back();
    if (settled_[index]) continue;
    settled_[index] = 1;
    ++done;
    if (index == base_) stop_at_ = next_.values[index] + kBehindBase;
    const auto column = w.column + static_cast<std::int32_t>(index % static_cast<std::size_t>(w.columns));
    const auto row = w.row + static_cast<std::int32_t>(index / static_cast<std::size_t>(w.columns));
    relax(column + 1, row);
    relax(column - 1, row);
    relax(column, row + 1);
    relax(column, row - 1);
  }
  return done;
}

// The first-order upwind solution of |grad T| = cost from the settled neighbours.
void NavigationFunction::relax(std::int32_t column, std::int32_t row) {
  const MapWindow& w = next_.window;
  if (!w.holds(column, row)) return;
  const std::size_t index = w.index(column, row);
  if (settled_[index]) return;
  const float cost = costs_.at(index, column, row);
  if (cost == kNever) return;
  const auto settled = [&](std::int32_t c, std::int32_t r) {
    return w.holds(c, r) && settled_[w.index(c, r)] ? next_.values[w.index(c, r)] : kNever;
  };
  const float across = std::min(settled(column - 1, row), settled(column + 1, row));
  const float along = std::min(settled(column, row - 1), settled(column, row + 1));
  const float step = cost * static_cast<float>(next_.cell);
  const float apart = std::abs(across - along);  // infinity or NaN where one of them is not settled
  float value = std::min(across, along) + step;
  if (apart < step) value = 0.5f * (across + along + std::sqrt(2.0f * step * step - apart * apart));
  offer(index, value);
}

void NavigationFunction::finish(Outcome outcome) {
  next_.outcome = outcome;
  std::swap(potential_, next_);
  next_.goal_x = potential_.goal_x;
  next_.goal_y = potential_.goal_y;
  stage_ = Stage::kIdle;
}

}  // namespace edgefusion
