// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/manoeuvre.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "edgefusion/cells.hpp"
#include "edgefusion/guard.hpp"
#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNone = std::numeric_limits<double>::infinity();
// Searched is a square about the start of this half side, in places so wide, and headings.
constexpr double kReach = 2.0, kPlace = 0.04;
constexpr std::int32_t kHeadings = 48;
constexpr auto kPlaces = static_cast<std::int32_t>(2.0 * kReach / kPlace);
// Points are found by bins of this side.
constexpr double kBin = 0.2, kMostMargin = 1.0;
constexpr std::size_t kMostNodes = 120'000;

constexpr double kStretch = 0.08, kTurn = 2.0 * kPi / kHeadings;
// What counts like a metre of way: a radian on the spot, a metre back, another kind of step.
constexpr double kTurnCost = 0.25, kBackCost = 2.5, kChangeCost = 0.05;
// Nearer than this to something, steps cost up to so much more: in the middle of a gap it is safest.
constexpr double kRoomy = 0.05, kCloseCost = 3.0;
// Within this of the way down, and with so many margins around it, the base is left to the field again.
constexpr double kFreeAgain = 3.0;
constexpr double kAlong = 0.5;
// Between two poses that are tried no point of the hull moves farther [m].
constexpr double kStride = 0.012;
constexpr double kLongestTurn = 0.75 * kPi;
constexpr double kRounding = 1e-9;

double turned(double a, double b) {
  return std::remainder(a - b, 2.0 * kPi);
}

Pose moved(const Pose& pose, double way, double turn) {
  const double half = 0.5 * turn;
  const double chord = half == 0.0 ? way : way * std::sin(half) / half;
  return {pose.x + chord * std::cos(pose.theta + half), pose.y + chord * std::sin(pose.theta + half),
          pose.theta + turn};
}

}  // namespace

const std::vector<Manoeuvre::Step>& Manoeuvre::steps() {
  static const std::vector<Step> all = [] {
    std::vector<Step> steps;
    for (const double curvature : {0.0, 2.0, -2.0, 5.0, -5.0}) {
      steps.push_back({kStretch, kStretch * curvature, kStretch});
      steps.push_back({-kStretch, kStretch * curvature, kBackCost * kStretch});
    }
    for (const double turn : {kTurn, -kTurn}) steps.push_back({0.0, turn, kTurnCost * kTurn});
    return steps;
  }();
  return all;
}

void Manoeuvre::begin(const ObstacleMap& map, const Potential& potential, const Pose& start, double margin,
                      const ManoeuvreTarget& target, const double* others, std::size_t k) {
  const double given[] = {start.x,
                          start.y,
                          start.theta,
                          margin,
                          target.value,
                          target.pose.x,
                          target.pose.y,
                          target.pose.theta,
                          target.position_tolerance,
                          target.heading_tolerance};
  expect_finite("start, margin, target", given, 10);
  if (!(margin >= 0.0 && margin <= kMostMargin))
    refuse("margin: expected from 0 to ", kMostMargin, ", got ", margin);
  expect_finite("others", others, 2 * k);
  start_ = start;
  target_ = target;
  nodes_.clear();
  open_.clear();
  legs_.clear();
  closed_.assign(static_cast<std::size_t>(kPlaces) * kPlaces * kHeadings, 0);
  std::vector<double> points(others, others + 2 * k);
  reach_ = footprint_.circumscribed() + margin;
  map.points_near(start.x, start.y, kReach + reach_, kDepth, points);
  margin_ = margin;
  fill_bins(points);
  running_ = true;
  push(potential, {start, 0.0, -1, -1});
}

void Manoeuvre::fill_bins(const std::vector<double>& points) {
  bins_ = floored(2.0 * (kReach + reach_) / kBin) + 1;
  points_.assign(static_cast<std::size_t>(bins_) * static_cast<std::size_t>(bins_), {});
  for (std::size_t i = 0; i < points.size(); i += 2) {
    const std::int32_t c = bin_of(points[i] - start_.x), r = bin_of(points[i + 1] - start_.y);
    if (c < 0 || c >= bins_ || r < 0 || r >= bins_) continue;
    std::vector<double>& bin = points_[static_cast<std::size_t>(r * bins_ + c)];
    const double cosine = std::cos(start_.theta), sine = std::sin(start_.theta);
    const double dx = points[i] - start_.x, dy = points[i + 1] - start_.y;
    const double now = footprint_.gap(cosine * dx + sine * dy, cosine * dy - sine * dx);
    // Points that are too near now count for as much as keeps the base from coming nearer still (guard.hpp).
    const double credit = now < kTooNear * margin_ ? margin_ - now : 0.0;
    bin.insert(bin.end(), {points[i], points[i + 1], credit});
  }
}

std::int32_t Manoeuvre::bin_of(double offset) const {
  return floored((offset + kReach + reach_) / kBin);
}

// From the hull to the nearest point, where one is nearer than the margin; minus infinity where it is too near.
double Manoeuvre::gap(const Pose& pose) const {
  const double cosine = std::cos(pose.theta), sine = std::sin(pose.theta);
  const auto bin_within = [this](double offset) { return std::clamp(bin_of(offset), 0, bins_ - 1); };
  const double x = pose.x - start_.x, y = pose.y - start_.y;
  double smallest = kNone;
  for (std::int32_t r = bin_within(y - reach_); r <= bin_within(y + reach_); ++r) {
    for (std::int32_t c = bin_within(x - reach_); c <= bin_within(x + reach_); ++c) {
      const std::vector<double>& bin = points_[static_cast<std::size_t>(r * bins_ + c)];
      for (std::size_t i = 0; i < bin.size(); i += 3) {
        const double dx = bin[i] - pose.x, dy = bin[i + 1] - pose.y;
        if (dx * dx + dy * dy > reach_ * reach_) continue;
        const double one = footprint_.gap(cosine * dx + sine * dy, cosine * dy - sine * dx) + bin[i + 2];
        if (bin[i + 2] > 0.0 && one < margin_ - kRounding) return -kNone;
        smallest = std::min(smallest, one);
      }
    }
  }
  return smallest;
}

// The smallest gap on a step, below 0 where it is shut; `to` is where it ends.
double Manoeuvre::room_along(const ObstacleMap& map, const Pose& from, const Step& step, Pose& to) const {
  const double swept = std::abs(step.way) + std::abs(step.turn) * footprint_.circumscribed();
  const int parts = std::max(1, static_cast<int>(std::ceil(swept / kStride)));
  // Nearer than the margin, as the start may be, it only gets farther away.
  const double least = std::min(margin_, gap(from));
  double smallest = kNone;
  for (int i = 1; i <= parts; ++i) {
    const double share = static_cast<double>(i) / parts;
    to = moved(from, share * step.way, share * step.turn);
    const double room = gap(to);
    if (room < least) return -1.0;
    smallest = std::min(smallest, room);
    if (step.way == 0.0) continue;
    const double edge = step.way > 0.0 ? footprint_.front() : footprint_.back();
    for (const double aside : {-0.5, 0.0, 0.5}) {
      const double y = aside * footprint_.inscribed();
      const double cosine = std::cos(to.theta), sine = std::sin(to.theta);
      if (!map.seen(to.x + cosine * edge - sine * y, to.y + sine * edge + cosine * y)) return -1.0;
    }
  }
  return smallest;
}

bool Manoeuvre::reached(const Potential& potential, const Pose& pose) const {
  if (target_.pose_counts) {
    const Pose& goal = target_.pose;
    return std::hypot(goal.x - pose.x, goal.y - pose.y) <= target_.position_tolerance &&
           std::abs(turned(goal.theta, pose.theta)) <= target_.heading_tolerance;
  }
  if (!(potential.value(pose.x, pose.y) <= target_.value) || gap(pose) < kFreeAgain * margin_) return false;
  const auto [dx, dy] = potential.descent(pose.x, pose.y);
  return std::abs(turned(std::atan2(dy, dx), pose.theta)) < kAlong;
}

double Manoeuvre::left(const Potential& potential, const Pose& pose) const {
  if (target_.pose_counts) {
    const Pose& goal = target_.pose;
    return std::hypot(goal.x - pose.x, goal.y - pose.y) +
           kTurnCost * std::abs(turned(goal.theta, pose.theta));
  }
  return std::max(0.0, potential.value(pose.x, pose.y) - target_.value);
}

// Where a pose belongs among all, their number where it lies outside.
std::size_t Manoeuvre::place(const Pose& pose) const {
  const auto c = static_cast<std::int32_t>(std::floor((pose.x - start_.x + kReach) / kPlace));
  const auto r = static_cast<std::int32_t>(std::floor((pose.y - start_.y + kReach) / kPlace));
  if (c < 0 || c >= kPlaces || r < 0 || r >= kPlaces) return closed_.size();
  const auto raw = static_cast<std::int32_t>(std::lround(turned(pose.theta, 0.0) / kTurn));
  const std::int32_t h = (raw + kHeadings) % kHeadings;
  return (static_cast<std::size_t>(r) * kPlaces + static_cast<std::size_t>(c)) * kHeadings +
         static_cast<std::size_t>(h);
}

void Manoeuvre::push(const Potential& potential, const Node& node) {
  const double estimate = node.cost + left(potential, node.pose);
  if (!std::isfinite(estimate)) return;
  nodes_.push_back(node);
  open_.push_back({estimate, static_cast<std::int32_t>(nodes_.size() - 1)});
  std::push_heap(open_.begin(), open_.end());
}

bool Manoeuvre::advance(const ObstacleMap& map, const Potential& potential, std::size_t poses) {
  for (std::size_t done = 0; running_ && done < poses;) {
    if (open_.empty() || nodes_.size() > kMostNodes) {
      running_ = false;
      break;
    }
    const std::int32_t current = open_.front().node;
    std::pop_heap(open_.begin(), open_.end());
    open_.pop_back();
    const Node node = nodes_[static_cast<std::size_t>(current)];
    const std::size_t at = place(node.pose);
    if (at >= closed_.size() || closed_[at]) continue;
    closed_[at] = 1;
    ++done;
    if (node.parent >= 0 && reached(potential, node.pose)) {
      finish(current);
      break;
    }
    for (std::size_t i = 0; i < steps().size(); ++i) {
      const Step& step = steps()[i];
      Pose to{};
      const double room = room_along(map, node.pose, step, to);
      if (room < 0.0) continue;
      const std::size_t next = place(to);
      if (next >= closed_.size() || closed_[next]) continue;
      const bool changes = node.step >= 0 && static_cast<std::size_t>(node.step) != i;
      push(potential,
           {to, node.cost + step.cost + (changes ? kChangeCost : 0.0), current, static_cast<std::int8_t>(i)});
    }
  }
  return !running_;
}

// From the end back to the start; steps of one kind in a row are one leg, as long as its end's heading tells which way
// it turned.
void Manoeuvre::finish(std::int32_t node) {
  running_ = false;
  std::int8_t before = -1;
  for (; nodes_[static_cast<std::size_t>(node)].parent >= 0;
       node = nodes_[static_cast<std::size_t>(node)].parent) {
    const Node& n = nodes_[static_cast<std::size_t>(node)];
    const Step& step = steps()[static_cast<std::size_t>(n.step)];
    if (n.step == before && std::abs(legs_.back().turn + step.turn) < kLongestTurn) {
      legs_.back().way += step.way;
      legs_.back().turn += step.turn;
    } else {
      legs_.push_back({step.way, step.turn, n.pose});
    }
    before = n.step;
  }
  std::reverse(legs_.begin(), legs_.end());
}

}  // namespace edgefusion
