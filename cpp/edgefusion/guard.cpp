// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/guard.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
// Between two poses that are tried no point of the hull moves farther [m], and no more time passes [s].
constexpr double kStride = 0.03, kTick = 0.05;
// A base nearer than the margin may come nearer by this much: its points are not exact [m].
constexpr double kGive = 0.001;
constexpr double kLeastShare = 0.5;  // but never nearer than this share of the margin
constexpr double kStill = 1e-3;      // slower than this nothing is [m/s, rad/s]

double ramped(double speed, double target, double change) {
  return target > speed ? std::min(target, speed + change) : std::max(target, speed - change);
}

void expect_ramps(const Ramps& ramps) {
  for (const auto& [name, value] :
       {std::pair{"acceleration", ramps.acceleration}, std::pair{"yaw_acceleration", ramps.yaw_acceleration}})
    if (!(value > 0.0 && std::isfinite(value)))
      refuse(name, ": expected a finite number above 0, got ", value);
}

void expect_duration(const char* name, double seconds) {
  if (!(seconds >= 0.0 && std::isfinite(seconds)))
    refuse(name, ": expected a finite number of at least 0, got ", seconds);
}

}  // namespace

Motion followed(const Motion& start, const Command& command, const Ramps& ramps, double duration) {
  expect_ramps(ramps);
  expect_duration("duration", duration);
  Motion m = start;
  constexpr double kStep = 0.05;
  for (double left = duration; left > 1e-9; left -= kStep) {
    const double dt = std::min(kStep, left);
    const double v = ramped(m.v, command.v, ramps.acceleration * dt);
    const double w = ramped(m.w, command.w, ramps.yaw_acceleration * dt);
    const double way = 0.5 * (m.v + v) * dt, turn = 0.5 * (m.w + w) * dt, middle = m.pose.theta + 0.5 * turn;
    m = {{m.pose.x + way * std::cos(middle), m.pose.y + way * std::sin(middle), m.pose.theta + turn}, v, w};
  }
  return m;
}

Guard::Guard(const Footprint& footprint, const Ramps& ramps) : footprint_(footprint), ramps_(ramps) {
  expect_ramps(ramps);
}

void Guard::look(const ObstacleMap& map, double x, double y, double reach, const double* moving,
                 std::size_t k) {
  const double given[] = {x, y, reach};
  expect_finite("x, y, reach", given, 3);
  expect_finite("moving", moving, 4 * k);
  std::vector<double> near;
  map.points_near(x, y, reach, kDepth, near);
  points_.clear();
  points_.reserve(near.size() / 2 + k);
  for (std::size_t i = 0; i < near.size(); i += 2) points_.push_back({near[i], near[i + 1], 0.0, 0.0});
  moving_ = 0;
  for (const bool moves : {false, true}) {
    for (std::size_t i = 0; i < k; ++i) {
      const double* p = moving + 4 * i;
      if ((p[2] != 0.0 || p[3] != 0.0) != moves) continue;
      points_.push_back({p[0], p[1], p[2], p[3]});
      moving_ += moves;
    }
  }
}

double Guard::gap(const Pose& pose) const {
  return gaps(pose, 0.0, kNone).standing;
}

// The smallest gaps after some time; points whose gap must be larger than `beyond` are not looked at.
Guard::Gaps Guard::gaps(const Pose& pose, double after, double beyond) const {
  const double cosine = std::cos(pose.theta), sine = std::sin(pose.theta);
  const double reach = footprint_.circumscribed() + beyond;
  const auto smallest = [&](std::size_t begin, std::size_t end) {
    double least = kNone;
    for (std::size_t i = begin; i < end; ++i) {
      const Point& p = points_[i];
      const double dx = p.x + after * p.vx - pose.x, dy = p.y + after * p.vy - pose.y;
      if (dx * dx + dy * dy > reach * reach) continue;
      least = std::min(least, footprint_.gap(cosine * dx + sine * dy, cosine * dy - sine * dx));
    }
    return least;
  };
  const std::size_t standing = points_.size() - moving_;
  return {smallest(0, standing), smallest(standing, points_.size())};
}

bool Guard::fits(const Pose& pose, double margin) const {
  const Gaps now = gaps(pose, 0.0, margin);
  return now.standing >= margin && now.moving >= margin;
}

Guard::Needs Guard::needs(const Pose& start, double margin) const {
  const double cosine = std::cos(start.theta), sine = std::sin(start.theta);
  const double reach = footprint_.circumscribed() + margin;
  std::vector<double> now(points_.size(), kNone);
  double smallest = kNone;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double dx = points_[i].x - start.x, dy = points_[i].y - start.y;
    if (dx * dx + dy * dy > reach * reach) continue;
    now[i] = footprint_.gap(cosine * dx + sine * dy, cosine * dy - sine * dx);
    if (now[i] >= kTooNear * margin) smallest = std::min(smallest, now[i]);
  }
  Needs needs{kept(smallest, margin), std::vector<double>(points_.size(), 0.0)};
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (now[i] < kTooNear * margin) needs.credits[i] = needs.least - kept(now[i], margin);
  return needs;
}

// Whether all gaps after some time are as large as they must be.
bool Guard::keeps(const Pose& pose, double after, const Needs& needs) const {
  const double cosine = std::cos(pose.theta), sine = std::sin(pose.theta);
  const double reach = footprint_.circumscribed() + needs.least;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& p = points_[i];
    const double dx = p.x + after * p.vx - pose.x, dy = p.y + after * p.vy - pose.y;
    if (dx * dx + dy * dy > reach * reach) continue;
    const double gap = footprint_.gap(cosine * dx + sine * dy, cosine * dy - sine * dx);
    if (gap + needs.credits[i] < needs.least) return false;
  }
  return true;
}

double kept(double gap, double margin) {
  if (gap >= margin) return margin;
  return std::min(gap, std::max(gap - kGive, kLeastShare * margin));
}

// The ground under the edge of the hull that goes ahead: its middle, and half way to either side.
bool Guard::shown(const ObstacleMap& map, const Pose& pose, double ahead) const {
  const double cosine = std::cos(pose.theta), sine = std::sin(pose.theta);
  for (const double aside : {-0.5, 0.0, 0.5}) {
    const double y = aside * footprint_.inscribed();
    if (!map.seen(pose.x + cosine * ahead - sine * y, pose.y + sine * ahead + cosine * y)) return false;
  }
  return true;
}

// Whether all that moves leaves a standing base alone.
bool Guard::passed_by(const Pose& pose, double from, double linger, double margin) const {
  const double cosine = std::cos(pose.theta), sine = std::sin(pose.theta);
  for (std::size_t i = points_.size() - moving_; i < points_.size(); ++i) {
    const Point& p = points_[i];
    for (double time = from; time <= from + linger; time += kTick) {
      const double dx = p.x + time * p.vx - pose.x, dy = p.y + time * p.vy - pose.y;
      if (footprint_.gap(cosine * dx + sine * dy, cosine * dy - sine * dx) < margin) return false;
    }
  }
  return true;
}

bool Guard::free(const ObstacleMap& map, const Motion& start, const Command& command, double hold,
                 double margin, double linger) const {
  const double given[] = {start.pose.x, start.pose.y, start.pose.theta, start.v,
                          start.w,      command.v,    command.w,        margin};
  expect_finite("motion, command, margin", given, 8);
  expect_duration("hold", hold);
  expect_duration("linger", linger);
  const Needs needed = needs(start.pose, margin);
  Motion m = start;
  for (double time = 0.0;;) {
    const bool braking = time >= hold;
    if (braking && std::abs(m.v) < kStill && std::abs(m.w) < kStill)
      return moving_ == 0 || passed_by(m.pose, time, linger, margin);
    const double rate = std::max(std::abs(m.v), std::abs(command.v)) +
                        std::max(std::abs(m.w), std::abs(command.w)) * footprint_.circumscribed();
    double dt = std::min(kTick, kStride / std::max(rate, kStride / kTick));
    if (!braking) dt = std::min(dt, hold - time);
    m = followed(m, braking ? Command{0.0, 0.0} : command, ramps_, dt);
    time += dt;
    if (!keeps(m.pose, time, needed)) return false;
    if (m.v > kStill && !shown(map, m.pose, footprint_.front())) return false;
    if (m.v < -kStill && !shown(map, m.pose, footprint_.back())) return false;
  }
}

}  // namespace edgefusion
