// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "edgefusion/dbscan.hpp"

using namespace edgefusion;

namespace {

using Labels = std::vector<std::int32_t>;
using Points = std::vector<double>;  // x, y, x, y, ...

Labels labels_of(const Points& points, double eps, int min_points) {
  Labels labels(points.size() / 2, 99);
  dbscan(points.data(), labels.size(), eps, min_points, labels.data());
  return labels;
}

std::string refusal(const Points& points, double eps, int min_points) {
  try {
    labels_of(points, eps, min_points);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// The definition, word by word: grow every cluster from its lowest core point, clusters in rising order.
class Definition {
 public:
  Definition(const Points& points, double eps, int min_points)
      : points_(points), eps_(eps), min_points_(min_points), labels_(points.size() / 2, kNoise) {}

  Labels labels() {
    std::int32_t next = 0;
    for (std::size_t i = 0; i < labels_.size(); ++i)
      if (labels_[i] == kNoise && is_core(i)) grow(i, next++);
    return labels_;
  }

 private:
  bool near(std::size_t a, std::size_t b) const {
    const double dx = points_[2 * a] - points_[2 * b];
    const double dy = points_[2 * a + 1] - points_[2 * b + 1];
    return dx * dx + dy * dy <= eps_ * eps_;
  }

  bool is_core(std::size_t i) const {
    int count = 0;
    for (std::size_t j = 0; j < labels_.size(); ++j) count += near(i, j);
    return count >= min_points_;
  }

  void grow(std::size_t first, std::int32_t label) {
    std::vector<std::size_t> open{first};
    labels_[first] = label;
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      if (!is_core(i)) continue;
      for (std::size_t j = 0; j < labels_.size(); ++j) {
        if (labels_[j] != kNoise || !near(i, j)) continue;
        labels_[j] = label;
        open.push_back(j);
      }
    }
  }

  const Points& points_;
  double eps_;
  int min_points_;
  Labels labels_;
};

constexpr double kHuge = 1e300;
constexpr double kTiny = 1e-300;

}  // namespace

TEST_CASE("No points have no labels") {
  CHECK(labels_of({}, 1.0, 1).empty());
}

TEST_CASE("A single point is a cluster only if one point is enough") {
  CHECK(labels_of({3.0, 4.0}, 1.0, 1) == Labels{0});
  CHECK(labels_of({3.0, 4.0}, 1.0, 2) == Labels{kNoise});
}

TEST_CASE("The ball is closed") {
  CHECK(labels_of({0, 0, 3, 4}, 5.0, 2) == Labels{0, 0});
  CHECK(labels_of({0, 0, 3, 4}, std::nextafter(5.0, 0.0), 2) == Labels{kNoise, kNoise});
}

TEST_CASE("Clusters are numbered by their lowest core point, not by their lowest point") {
  // Row 0 is a border point of the right cluster, whose core points come after those of the left one.
  const Points points{12, 0, 0, 0, 1, 0, 0, 1, 11, 0, 10, 0, 10, 1};
  CHECK(labels_of(points, 1.0, 3) == Labels{1, 0, 0, 0, 1, 1, 1});
}

TEST_CASE("A border point joins the lowest cluster that reaches it") {
  const Points points{2, 0, 4, 0, 4.5, 0, 4, 0.5, 0, 0, -0.5, 0, 0, 0.5};
  CHECK(labels_of(points, 2.0, 4) == Labels{0, 0, 0, 0, 1, 1, 1});
}

TEST_CASE("The labels are those of the definition") {
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    const int extent = 1 + round % 12;
    std::uniform_int_distribution<int> coordinate(-extent, extent);
    Points points(2 * static_cast<std::size_t>(round % 60));
    for (double& value : points) value = coordinate(random);
    const double eps = std::sqrt(1 + round % 9);
    const int min_points = 1 + round % 7;
    CAPTURE(round);
    CHECK(labels_of(points, eps, min_points) == Definition(points, eps, min_points).labels());
  }
}

TEST_CASE("Scaling by a power of two changes no label, from one end of the doubles to the other") {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> coordinate(-9, 9);
  Points points(200);
  for (double& value : points) value = coordinate(random);
  const Labels expected = Definition(points, 2.0, 5).labels();
  for (const int exponent : {-1074, -1000, -500, -1, 1, 500, 1000, 1019}) {
    Points scaled = points;
    for (double& value : scaled) value = std::ldexp(value, exponent);
    CAPTURE(exponent);
    CHECK(labels_of(scaled, std::ldexp(2.0, exponent), 5) == expected);
  }
}

TEST_CASE("Huge coordinates, whose squares overflow, are told apart") {
  const Points points{kHuge, 0, kHuge, 0, -kHuge, 0, -kHuge, 0, 1, 1};
  CHECK(labels_of(points, 1.0, 2) == Labels{0, 0, 1, 1, kNoise});
  CHECK(labels_of(points, kTiny, 2) == Labels{0, 0, 1, 1, kNoise});
  CHECK(labels_of(points, kHuge, 2) == Labels{0, 0, 0, 0, 0});
  const double most = std::numeric_limits<double>::max();
  CHECK(labels_of({-most, -most, most, most}, most, 2) == Labels{kNoise, kNoise});
}

TEST_CASE("Tiny distances, whose squares vanish, are told apart") {
  const Points points{0, 0, 1e-300, 0, 3e-300, 0, 1, 0};
  CHECK(labels_of(points, kTiny, 2) == Labels{0, 0, kNoise, kNoise});
  CHECK(labels_of(points, 2.5e-300, 2) == Labels{0, 0, 0, kNoise});
}

TEST_CASE("Many equal points take no more than linear time and memory") {
  const std::size_t n = 200000;
  const Points points(2 * n, 7.0);
  CHECK(labels_of(points, 1.0, 5) == Labels(n, 0));
  CHECK(labels_of(points, 1.0, static_cast<int>(n)) == Labels(n, 0));
  CHECK(labels_of(points, 1.0, static_cast<int>(n) + 1) == Labels(n, kNoise));
}

TEST_CASE("Two crowds that face each other along a curved gap are told apart in near-linear time") {
  const std::size_t n = 100000;  // all pairs would take minutes
  const double gap = 1.0001;
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 0.6 * static_cast<double>(i) / static_cast<double>(n);
    for (const double radius : {0.5, 0.5 + gap}) {
      points.push_back(radius * std::cos(angle));
      points.push_back(radius * std::sin(angle));
    }
  }
  const Labels apart = labels_of(points, 1.0, 5);
  CHECK(apart[0] == 0);
  CHECK(apart[1] == 1);
  CHECK(labels_of(points, gap * 1.0001, 5) == Labels(2 * n, 0));
}

TEST_CASE("Refusals name what was expected and what came") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(refusal({0, 0, 1, nan}, 1.0, 2) == "points: expected finite coordinates, got (1, nan) in row 1");
  CHECK(refusal({-inf, 0}, 1.0, 2) == "points: expected finite coordinates, got (-inf, 0) in row 0");
  CHECK(refusal({0, 0}, 0.0, 2) == "eps: expected a finite number above 0, got 0");
  CHECK(refusal({0, 0}, nan, 2) == "eps: expected a finite number above 0, got nan");
  CHECK(refusal({0, 0}, inf, 2) == "eps: expected a finite number above 0, got inf");
  CHECK(refusal({}, -1.0, 2) == "eps: expected a finite number above 0, got -1");
  CHECK(refusal({0, 0}, 1.0, 0) == "min_points: expected at least 1, got 0");
}
