// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/navigation_function.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "edgefusion/cells.hpp"
#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
// Of a cell near which nothing is.
constexpr float kNoPoint = std::numeric_limits<float>::infinity();
// Seen once, a point stops the base but shuts no way: a beam that lies on two surfaces may have made it up.
constexpr int kConfirmed = 2;
// What a metre costs more where the base failed once to get through.
constexpr double kAvoided = 10.0;
// The marching goes on so far behind the base, for the ways that it may take from there [m].
constexpr float kBehindBase = 1.0f;

// The nearest cell within reach that is fit; the window's size where there is none.
template <typename Fit>
std::size_t nearest_cell(const MapWindow& w, double cell, double x, double y, double reach, Fit&& fit) {
  std::size_t found = w.size();
  double nearest = reach;
  const std::int32_t last = std::min(floored((x + reach) / cell), w.column + w.columns - 1);
  const std::int32_t top = std::min(floored((y + reach) / cell), w.row + w.rows - 1);
  for (std::int32_t r = std::max(floored((y - reach) / cell), w.row); r <= top; ++r) {
    for (std::int32_t c = std::max(floored((x - reach) / cell), w.column); c <= last; ++c) {
      const double apart = std::hypot((c + 0.5) * cell - x, (r + 0.5) * cell - y);
      if (apart >= nearest || !fit(w.index(c, r), c, r)) continue;
      nearest = apart;
      found = w.index(c, r);
    }
  }
  return found;
}

}  // namespace

NavigationFunction::NavigationFunction(const WayCost& cost) : cost_(cost) {
  const std::pair<const char*, double> all[] = {
      {"blocked", cost.blocked}, {"comfort", cost.comfort}, {"weight", cost.weight}};
  for (const auto& [name, value] : all)
    if (!(value >= 0.0 && std::isfinite(value)))
      refuse(name, ": expected a finite number of at least 0, got ", value);
  if (!(cost.comfort > cost.blocked))
    refuse("comfort: expected more than blocked, ", cost.blocked, ", got ", cost.comfort);
}

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
  next_.nearest.resize(next_.window.size());
  settled_.assign(next_.window.size(), 0);
  avoided_.resize(next_.window.size());
  heap_.clear();
  row_ = 0;
  stage_ = Stage::kDown;
}

bool NavigationFunction::advance(const ObstacleMap& map, std::size_t cells) {
  if (stage_ == Stage::kIdle) return false;
  if (!(next_.window == map.window())) restart(map);
  if (stage_ == Stage::kDown) cells -= std::min(cells, sweep_down(map, cells));
  if (stage_ == Stage::kUp) cells -= std::min(cells, sweep_up(cells));
  if (stage_ == Stage::kMarch) march(cells);
  return stage_ == Stage::kIdle;
}

// The nearest point of a cell is that of a neighbour, if any is near (Danielsson 1980): two sweeps over all cells find
// it, the first from the lowest row upwards.
bool NavigationFunction::take(std::size_t to, std::size_t from, double x, double y) {
  const Point point = next_.nearest[from];
  if (point.x == kNoPoint) return false;
  const auto apart = [x, y](const Point& p) {
    const double dx = static_cast<double>(p.x) - x, dy = static_cast<double>(p.y) - y;
    return dx * dx + dy * dy;
  };
  const double squared = apart(point);
  // A little farther than it counts: a cell's nearest point comes to it through its neighbours.
  const double farthest = cost_.comfort + 2.0 * next_.cell;
  if (squared > farthest * farthest) return false;
  Point& own = next_.nearest[to];
  if (own.x != kNoPoint && apart(own) <= squared) return false;
  own = point;
  return true;
}

std::size_t NavigationFunction::sweep_down(const ObstacleMap& map, std::size_t cells) {
  const MapWindow& w = next_.window;
  const auto columns = static_cast<std::size_t>(w.columns);
  std::size_t done = 0;
  for (; row_ < w.rows && done < cells; ++row_, done += columns) {
    const std::size_t first = static_cast<std::size_t>(row_) * columns;
    const double y = middle(w.row + row_);
    for (std::size_t c = 0; c < columns; ++c) {
      const ObstacleMap::Cell& cell = map.at(first + c);
      avoided_[first + c] = cell.avoided;
      next_.nearest[first + c] =
          cell.evidence > 0 && cell.points >= kConfirmed ? Point{cell.x, cell.y} : Point{kNoPoint, kNoPoint};
    }
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
    stage_ = Stage::kUp;
    row_ = w.rows - 1;
  }
  return done;
}

std::size_t NavigationFunction::sweep_up(std::size_t cells) {
  const MapWindow& w = next_.window;
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
  if (row_ < 0) {
    stage_ = Stage::kMarch;
    stop_at_ = kNever;
    seed();
  }
  return done;
}

// Infinity where the base cannot be.
float NavigationFunction::cost_at(std::size_t index, std::int32_t column, std::int32_t row) const {
  const Point& point = next_.nearest[index];
  const double failed = kAvoided * static_cast<double>(avoided_[index]);
  if (point.x == kNoPoint) return static_cast<float>(1.0 + failed);
  const double apart =
      std::hypot(static_cast<double>(point.x) - middle(column), static_cast<double>(point.y) - middle(row));
  if (apart < cost_.blocked) return kNever;
  const double near = (cost_.comfort - apart) / (cost_.comfort - cost_.blocked);
  return static_cast<float>(1.0 + failed + (near <= 0.0 ? 0.0 : cost_.weight * near * near));
}

void NavigationFunction::seed() {
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
      const double apart = std::hypot(middle(c) - next_.goal_x, middle(r) - next_.goal_y);
      const float cost = cost_at(w.index(c, r), c, r);
      if (apart <= reach && cost != kNever) offer(w.index(c, r), cost * static_cast<float>(apart));
    }
  }
}

// Beyond the border all ground is taken for free: from there it is as far as the bird flies.
void NavigationFunction::seed_border() {
  const MapWindow& w = next_.window;
  const auto at = [&](std::int32_t c, std::int32_t r) {
    if (cost_at(w.index(c, r), c, r) != kNever)
      offer(w.index(c, r),
            static_cast<float>(std::hypot(middle(c) - next_.goal_x, middle(r) - next_.goal_y)));
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
      next_.window, next_.cell, base_x_, base_y_, cost_.blocked + next_.cell,
      [this](std::size_t i, std::int32_t c, std::int32_t r) { return cost_at(i, c, r) != kNever; });
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
  const float cost = cost_at(index, column, row);
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
  std::swap(field_, next_);
  next_.goal_x = field_.goal_x;
  next_.goal_y = field_.goal_y;
  stage_ = Stage::kIdle;
}

float NavigationFunction::value_at(std::int32_t column, std::int32_t row) const {
  return field_.window.holds(column, row) ? field_.values[field_.window.index(column, row)] : kNever;
}

namespace {

// The four cells around a point, and their shares of a bilinear mixture.
struct Corners {
  std::int32_t column, row;
  double right, up;

  Corners(double x, double y, double cell) {
    const double c = x / cell - 0.5, r = y / cell - 0.5;
    column = floored(c);
    row = floored(r);
    right = c - column;
    up = r - row;
  }
  template <typename Visit>
  void each(Visit&& visit) const {
    visit(column, row, (1.0 - right) * (1.0 - up));
    visit(column + 1, row, right * (1.0 - up));
    visit(column, row + 1, (1.0 - right) * up);
    visit(column + 1, row + 1, right * up);
  }
};

}  // namespace

double NavigationFunction::value(double x, double y) const {
  if (field_.values.empty()) return std::numeric_limits<double>::infinity();
  double sum = 0.0, shares = 0.0;
  Corners(x, y, field_.cell).each([&](std::int32_t c, std::int32_t r, double share) {
    const float value = value_at(c, r);
    if (value == kNever) return;
    sum += share * static_cast<double>(value);
    shares += share;
  });
  return shares > 0.0 ? sum / shares : std::numeric_limits<double>::infinity();
}

std::pair<double, double> NavigationFunction::slope(std::int32_t column, std::int32_t row) const {
  const float here = value_at(column, row);
  const auto upwind = [here](float before, float behind) {
    const float least = std::min(before, behind);
    if (!(least < here)) return 0.0;
    return static_cast<double>(before < behind ? here - before : behind - here);
  };
  return {upwind(value_at(column - 1, row), value_at(column + 1, row)),
          upwind(value_at(column, row - 1), value_at(column, row + 1))};
}

std::pair<double, double> NavigationFunction::descent(double x, double y) const {
  if (field_.values.empty()) return {0.0, 0.0};
  // At the goal itself the cells are too coarse.
  const double to_x = field_.goal_x - x, to_y = field_.goal_y - y, apart = std::hypot(to_x, to_y);
  if (apart > 0.0 && apart < 2.0 * field_.cell && value(x, y) < 4.0 * field_.cell)
    return {to_x / apart, to_y / apart};
  double dx = 0.0, dy = 0.0;
  Corners(x, y, field_.cell).each([&](std::int32_t c, std::int32_t r, double share) {
    if (value_at(c, r) == kNever) return;
    const auto [sx, sy] = slope(c, r);
    const double length = std::hypot(sx, sy);
    if (length == 0.0) return;
    dx -= share * sx / length;
    dy -= share * sy / length;
  });
  const double length = std::hypot(dx, dy);
  return length > 0.0 ? std::pair(dx / length, dy / length) : std::pair(0.0, 0.0);
}

void NavigationFunction::way(double x, double y, double length, double reach,
                             std::vector<double>& points) const {
  const double given[] = {length, reach};
  expect_finite("length, reach", given, 2);
  if (field_.values.empty()) return;
  const MapWindow& w = field_.window;
  const double step = 0.5 * field_.cell;
  if (value(x, y) == std::numeric_limits<double>::infinity()) {
    const auto known = [this](std::size_t i, std::int32_t, std::int32_t) {
      return field_.values[i] != kNever;
    };
    const std::size_t from = nearest_cell(w, field_.cell, x, y, reach, known);
    if (from == w.size()) return;
    const auto columns = static_cast<std::size_t>(w.columns);
    x = (w.column + static_cast<std::int32_t>(from % columns) + 0.5) * field_.cell;
    y = (w.row + static_cast<std::int32_t>(from / columns) + 0.5) * field_.cell;
  }
  points.push_back(x);
  points.push_back(y);
  for (double gone = 0.0; gone < length; gone += step) {
    if (std::hypot(field_.goal_x - x, field_.goal_y - y) <= step) {
      points.push_back(field_.goal_x);
      points.push_back(field_.goal_y);
      return;
    }
    const auto [dx, dy] = descent(x, y);
    if (dx == 0.0 && dy == 0.0) return;
    x += step * dx;
    y += step * dy;
    points.push_back(x);
    points.push_back(y);
  }
}

double NavigationFunction::clearance(double x, double y) const {
  const double far = std::numeric_limits<double>::infinity();
  if (field_.values.empty()) return far;
  const std::int32_t column = floored(x / field_.cell), row = floored(y / field_.cell);
  if (!field_.window.holds(column, row)) return far;
  const Point& point = field_.nearest[field_.window.index(column, row)];
  if (point.x == kNoPoint) return far;
  return std::hypot(static_cast<double>(point.x) - x, static_cast<double>(point.y) - y);
}

}  // namespace edgefusion
