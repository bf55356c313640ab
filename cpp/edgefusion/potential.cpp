// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/potential.hpp"

#include <algorithm>
#include <cmath>

#include "edgefusion/refuse.hpp"

namespace edgefusion {
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

float Potential::value_at(std::int32_t column, std::int32_t row) const {
  return window.holds(column, row) ? values[window.index(column, row)] : kNever;
}

double Potential::value(double x, double y) const {
  if (values.empty()) return std::numeric_limits<double>::infinity();
  double sum = 0.0, shares = 0.0;
  Corners(x, y, cell).each([&](std::int32_t c, std::int32_t r, double share) {
    const float corner = value_at(c, r);
    if (corner == kNever) return;
    sum += share * static_cast<double>(corner);
    shares += share;
  });
  return shares > 0.0 ? sum / shares : std::numeric_limits<double>::infinity();
}

std::pair<double, double> Potential::slope(std::int32_t column, std::int32_t row) const {
  const float here = value_at(column, row);
  const auto upwind = [here](float before, float behind) {
    const float least = std::min(before, behind);
    if (!(least < here)) return 0.0;
    return static_cast<double>(before < behind ? here - before : behind - here);
  };
  return {upwind(value_at(column - 1, row), value_at(column + 1, row)),
          upwind(value_at(column, row - 1), value_at(column, row + 1))};
}

std::pair<double, double> Potential::descent(double x, double y) const {
  if (values.empty()) return {0.0, 0.0};
  // At the goal itself the cells are too coarse.
  const double to_x = goal_x - x, to_y = goal_y - y, apart = std::hypot(to_x, to_y);
  if (apart > 0.0 && apart < 2.0 * cell && value(x, y) < 4.0 * cell) return {to_x / apart, to_y / apart};
  double dx = 0.0, dy = 0.0;
  Corners(x, y, cell).each([&](std::int32_t c, std::int32_t r, double share) {
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

bool Potential::begin_nearby(double reach, double& x, double& y) const {
  const auto known = [this](std::size_t i, std::int32_t, std::int32_t) { return values[i] != kNever; };
  const std::size_t from = nearest_cell(window, cell, x, y, reach, known);
  if (from == window.size()) return false;
  const auto columns = static_cast<std::size_t>(window.columns);
  x = middle(window.column + static_cast<std::int32_t>(from % columns));
  y = middle(window.row + static_cast<std::int32_t>(from / columns));
  return true;
}

void Potential::way(double x, double y, double length, double reach, std::vector<double>& points) const {
  const double given[] = {length, reach};
  expect_finite("length, reach", given, 2);
  if (values.empty()) return;
  const double step = 0.5 * cell;
  if (value(x, y) == std::numeric_limits<double>::infinity() && !begin_nearby(reach, x, y)) return;
  points.push_back(x);
  points.push_back(y);
  for (double gone = 0.0; gone < length; gone += step) {
    if (std::hypot(goal_x - x, goal_y - y) <= step) {
      points.push_back(goal_x);
      points.push_back(goal_y);
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

}  // namespace edgefusion
