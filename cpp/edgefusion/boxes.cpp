// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "edgefusion/projection.hpp"
#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

// Pixels in which pixel i reaches from i to i + 1, as boxes count them; OpenCV puts its centre at i.
constexpr double kPixelCentre = 0.5;
// Keeps what lies far outside the image within the range of an integer.
constexpr double kFarOutside = 1e6;

double bounded(double pixel) {
  return std::max(-kFarOutside, std::min(kFarOutside, pixel));
}

struct Rectangle {
  double x0, y0, x1, y1;

  double area() const { return std::max(0.0, x1 - x0) * std::max(0.0, y1 - y0); }
};

// What the camera sees of a cluster: its extent across the image and the nearest beam it sees.
struct View {
  double left = std::numeric_limits<double>::infinity();
  double right = -std::numeric_limits<double>::infinity();
  double nearest_m = std::numeric_limits<double>::infinity();
  Eigen::Vector3d nearest = Eigen::Vector3d::Zero();  // laser frame

  bool empty() const { return !(left < right) || !std::isfinite(nearest_m); }
};

class Projector {
 public:
  Projector(const Camera& camera, const Eigen::Matrix4d& T_camera_laser)
      : camera_(camera),
        R_(T_camera_laser.topLeftCorner<3, 3>()),
        t_(T_camera_laser.topRightCorner<3, 1>()) {}

  bool see(const Eigen::Vector3d& point, Eigen::Vector2d& pixel) const {
    return camera_.project(R_ * point + t_, pixel) == Mark::kVisible;
  }

 private:
  const Camera& camera_;
  const Eigen::Matrix3d R_;
  const Eigen::Vector3d t_;
};

Eigen::Vector3d on_beam(double range, double angle) {
  return {range * std::cos(angle), range * std::sin(angle), 0.0};
}

// A beam hits somewhere in its own sector: on average the thing reaches half a step beyond its outermost
// beams.
View view_of(const Beams& beams, const Projector& projector) {
  View view;
  Eigen::Vector2d pixel;
  for (std::size_t i = 0; i < beams.n; ++i) {
    const double range = beams.ranges_m[i], angle = beams.angles_rad[i];
    for (const double side : {-0.5, 0.5}) {
      if (!projector.see(on_beam(range, angle + side * beams.step_rad), pixel)) continue;
      view.left = std::min(view.left, bounded(pixel.x() + kPixelCentre));
      view.right = std::max(view.right, bounded(pixel.x() + kPixelCentre));
    }
    const Eigen::Vector3d centre = on_beam(range, angle);
    if (range < view.nearest_m && projector.see(centre, pixel)) {
      view.nearest_m = range;
      view.nearest = centre;
    }
  }
  return view;
}

// The row of a point, or the image's edge on that side where the camera cannot see so far off axis.
double row_of(const Projector& projector, const Eigen::Vector3d& point, double edge) {
  Eigen::Vector2d pixel;
  return projector.see(point, pixel) ? bounded(pixel.y() + kPixelCentre) : edge;
}

Rectangle clipped(const Rectangle& r, int width, int height) {
  return {std::max(r.x0, 0.0), std::max(r.y0, 0.0), std::min(r.x1, static_cast<double>(width)),
          std::min(r.y1, static_cast<double>(height))};
}

// Whole pixels, at least one, for a rectangle inside the image.
Box rounded(const Rectangle& r, int width, int height) {
  const auto x0 = std::min(static_cast<std::int32_t>(std::lround(r.x0)), width - 1);
  const auto y0 = std::min(static_cast<std::int32_t>(std::lround(r.y0)), height - 1);
  return {x0, y0, std::max(static_cast<std::int32_t>(std::lround(r.x1)), x0 + 1),
          std::max(static_cast<std::int32_t>(std::lround(r.y1)), y0 + 1)};
}

bool above_zero(double value) {
  return value > 0.0 && std::isfinite(value);
}

void check(const Beams& beams) {
  expect_finite("ranges_m", beams.ranges_m, beams.n);
  expect_finite("angles_rad", beams.angles_rad, beams.n);
  if (!above_zero(beams.step_rad)) refuse("step_rad: expected a finite number above 0, got ", beams.step_rad);
}

void check(const BoxRule& rule) {
  if (rule.heights.empty()) refuse("heights: expected at least one, got none");
  for (std::size_t k = 0; k < rule.heights.size(); ++k)
    if (!above_zero(rule.heights[k]))
      refuse("heights: expected finite numbers above 0, got ", rule.heights[k], " at index ", k);
  if (!(rule.width_step >= 0.0 && std::isfinite(rule.width_step)))
    refuse("width_step: expected a finite number of at least 0, got ", rule.width_step);
  if (!(rule.min_visible > 0.0 && rule.min_visible <= 1.0))
    refuse("min_visible: expected above 0 and at most 1, got ", rule.min_visible);
}

void check_scene(const ToGround& to_ground, int width, int height) {
  expect_finite("to_ground", to_ground.data(), 3);
  if (to_ground.isZero(0.0)) refuse("to_ground: expected a length above 0, got (0, 0, 0)");
  if (width < 1) refuse("width: expected at least 1, got ", width);
  if (height < 1) refuse("height: expected at least 1, got ", height);
}

}  // namespace

std::size_t candidate_boxes(const Beams& beams, const Camera& camera, const Eigen::Matrix4d& T_camera_laser,
                            const ToGround& to_ground, int width, int height, const BoxRule& rule, Box* boxes,
                            std::int32_t* indices) {
  check(beams);
  check(rule);
  check_transform("T_camera_laser", T_camera_laser);
  check_scene(to_ground, width, height);
  const Projector projector(camera, T_camera_laser);
  const View view = view_of(beams, projector);
  if (view.empty()) return 0;

  const Eigen::Vector3d foot = rule.on_ground ? Eigen::Vector3d(view.nearest + to_ground) : view.nearest;
  const Eigen::Vector3d up = -to_ground.stableNormalized();
  const double bottom = row_of(projector, foot, height);
  const double centre = 0.5 * (view.left + view.right);

  std::size_t written = 0;
  for (std::size_t k = 0; k < rule.heights.size(); ++k) {
    const double half = 0.5 * (view.right - view.left) * (1.0 + static_cast<double>(k) * rule.width_step);
    const double top = rule.heights_are_metric ? row_of(projector, foot + rule.heights[k] * up, 0.0)
                                               : bottom - rule.heights[k] * 2.0 * half;
    const Rectangle whole{centre - half, top, centre + half, bottom};
    const Rectangle inside = clipped(whole, width, height);
    if (!(inside.area() > 0.0) || inside.area() < rule.min_visible * whole.area()) continue;
    boxes[written] = rounded(inside, width, height);
    indices[written++] = static_cast<std::int32_t>(k);
  }
  return written;
}

}  // namespace edgefusion
