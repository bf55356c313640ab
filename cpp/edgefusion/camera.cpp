// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "edgefusion/polynomial.hpp"
#include "edgefusion/refuse.hpp"

namespace edgefusion {
namespace {

// Order of OpenCV's coefficients.
enum Coefficient { K1, K2, P1, P2, K3, K4, K5, K6, S1, S2, S3, S4, TAU_X, TAU_Y };

std::array<double, 14> padded(const std::vector<double>& distortion) {
  const std::size_t n = distortion.size();
  if (n != 0 && n != 4 && n != 5 && n != 8 && n != 12 && n != 14)
    refuse("distortion: expected 0, 4, 5, 8, 12 or 14 coefficients, got ", n);
  expect_finite("distortion", distortion.data(), n);
  std::array<double, 14> k{};
  std::copy(distortion.begin(), distortion.end(), k.begin());
  return k;
}

// Maps the ideal image plane onto a sensor that is turned by tau_x and tau_y (Scheimpflug).
Eigen::Matrix3d tilt_matrix(double tau_x, double tau_y) {
  Eigen::Matrix3d about_x, about_y, onto_sensor;
  about_x << 1, 0, 0, 0, std::cos(tau_x), std::sin(tau_x), 0, -std::sin(tau_x), std::cos(tau_x);
  about_y << std::cos(tau_y), 0, -std::sin(tau_y), 0, 1, 0, std::sin(tau_y), 0, std::cos(tau_y);
  const Eigen::Matrix3d R = about_y * about_x;
  onto_sensor << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;
  return onto_sensor * R;
}

// The distorted radius is r N(u) / D(u) with u = r^2. It grows while its derivative,
// (N D + 2 u (N' D - N D')) / D^2, is positive and D has no pole. Beyond, one pixel has two directions, and
// OpenCV's formula returns the wrong one.
double radius_of_growth(const std::array<double, 14>& k) {
  const Polynomial N{1.0, k[K1], k[K2], k[K3]}, D{1.0, k[K4], k[K5], k[K6]};
  const Polynomial turn = add(multiply(derivative(N), D), scale(multiply(N, derivative(D)), -1.0));
  const Polynomial growth = add(multiply(N, D), multiply({0.0, 2.0}, turn));
  double u = std::numeric_limits<double>::infinity();
  for (const Polynomial& p : {growth, D}) {
    const std::vector<double> changes = positive_sign_changes(p);
    if (!changes.empty()) u = std::min(u, changes.front());
  }
  return std::sqrt(u);
}

}  // namespace

void check_intrinsics(const Eigen::Matrix3d& K) {
  if (!K.allFinite()) refuse("K: expected finite numbers");
  if (!(K(0, 0) > 0.0 && K(1, 1) > 0.0))
    refuse("K: expected focal lengths above 0, got ", K(0, 0), " and ", K(1, 1));
  if (K(0, 1) != 0.0 || K(1, 0) != 0.0 || K.row(2) != Eigen::RowVector3d(0, 0, 1))
    refuse("K: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
}

Camera::Camera(const Eigen::Matrix3d& K, const std::vector<double>& distortion)
    : K_(K),
      k_(padded(distortion)),
      tilt_(tilt_matrix(k_[TAU_X], k_[TAU_Y])),
      max_radius_(radius_of_growth(k_)) {
  check_intrinsics(K);
}

Mark Camera::project(const Eigen::Vector3d& point, Eigen::Vector2d& pixel) const {
  pixel.setConstant(std::numeric_limits<double>::quiet_NaN());
  if (!(point.z() > 0.0)) return Mark::kBehind;
  const Eigen::Vector2d undistorted = point.head<2>() / point.z();
  if (!(undistorted.norm() < max_radius_) || !keeps_orientation(undistorted)) return Mark::kBeyond;
  const Eigen::Vector3d distorted = distort(undistorted);
  const Eigen::Vector2d found = (K_ * distorted).hnormalized();
  // Before the tilted sensor, and no overflow on the way.
  if (!(distorted.z() > 0.0) || !found.allFinite()) return Mark::kBeyond;
  pixel = found;
  return Mark::kVisible;
}

Eigen::Vector3d Camera::distort(const Eigen::Vector2d& undistorted) const {
  const double x = undistorted.x(), y = undistorted.y();
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial =
      (1 + k_[K1] * r2 + k_[K2] * r4 + k_[K3] * r6) / (1 + k_[K4] * r2 + k_[K5] * r4 + k_[K6] * r6);
  const Eigen::Vector2d tangential(2 * k_[P1] * x * y + k_[P2] * (r2 + 2 * x * x),
                                   k_[P1] * (r2 + 2 * y * y) + 2 * k_[P2] * x * y);
  const Eigen::Vector2d prism(k_[S1] * r2 + k_[S2] * r4, k_[S3] * r2 + k_[S4] * r4);
  const Eigen::Vector2d distorted = radial * undistorted + tangential + prism;
  return tilt_ * distorted.homogeneous();
}

// Whether the picture is not turned over here: the determinant of distort's derivative is positive. The tilt
// has no part in it, it turns nothing over that lies before the sensor.
bool Camera::keeps_orientation(const Eigen::Vector2d& undistorted) const {
  const double x = undistorted.x(), y = undistorted.y();
  const double u = x * x + y * y, u2 = u * u;
  const double N = 1 + k_[K1] * u + k_[K2] * u2 + k_[K3] * u2 * u;
  const double D = 1 + k_[K4] * u + k_[K5] * u2 + k_[K6] * u2 * u;
  const double dN = k_[K1] + 2 * k_[K2] * u + 3 * k_[K3] * u2;
  const double dD = k_[K4] + 2 * k_[K5] * u + 3 * k_[K6] * u2;
  const double radial = N / D, d_radial = (dN - radial * dD) / D;  // by u
  const double prism_x = k_[S1] + 2 * k_[S2] * u, prism_y = k_[S3] + 2 * k_[S4] * u;
  const double across = 2 * (x * y * d_radial + k_[P1] * x + k_[P2] * y);
  const double xx = radial + 2 * (x * x * d_radial + k_[P1] * y + 3 * k_[P2] * x + prism_x * x);
  const double yy = radial + 2 * (y * y * d_radial + 3 * k_[P1] * y + k_[P2] * x + prism_y * y);
  const double xy = across + 2 * prism_x * y, yx = across + 2 * prism_y * x;
  return xx * yy - xy * yx > 0.0;
}

}  // namespace edgefusion
