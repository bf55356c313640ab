// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// What the thread sanitizer watches: the functions that Python calls without its lock share nothing.
#include <doctest/doctest.h>

#include <cstddef>
#include <random>
#include <thread>
#include <vector>

#include "edgefusion/boxes.hpp"
#include "edgefusion/crops.hpp"
#include "edgefusion/dbscan.hpp"
#include "edgefusion/nearest_range.hpp"
#include "edgefusion/projection.hpp"
#include "edgefusion/raycast.hpp"

using namespace edgefusion;

namespace {

// Shared by all threads, and only read.
struct Input {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(3 * 120 * 160);
  std::vector<double> points = std::vector<double>(3 * 600);
  Camera camera = Camera(Eigen::Matrix3d::Identity(), {-0.1, 0.01, 0, 0});

  Input() {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> coordinate(1, 20);
    for (auto& byte : pixels) byte = static_cast<std::uint8_t>(random());
    for (double& value : points) value = coordinate(random);
  }
};

struct Output {
  std::vector<std::int32_t> labels = std::vector<std::int32_t>(900);
  std::vector<float> crops = std::vector<float>(2 * 3 * 40 * 40);
  std::vector<double> projected = std::vector<double>(2 * 600);
  std::vector<std::uint8_t> marks = std::vector<std::uint8_t>(600);
  std::vector<std::int32_t> boxes;
  double range_m = 0;
  std::vector<double> ranges = std::vector<double>(90);
  std::vector<std::int32_t> hits = std::vector<std::int32_t>(90);

  bool operator==(const Output& other) const {
    return labels == other.labels && crops == other.crops && marks == other.marks && boxes == other.boxes &&
           range_m == other.range_m && ranges == other.ranges && hits == other.hits;
  }
};

Output run(const Input& input) {
  Output out;
  dbscan(input.points.data(), out.labels.size(), 0.7, 3, out.labels.data());

  const Box boxes[] = {{3, 5, 100, 90}, {40, 0, 160, 120}};
  for (const Filter filter : {Filter::kLinear, Filter::kAntialias})
    crops({input.pixels.data(), 120, 160, 3 * 160, 3, 1}, boxes, 2,
          {40, {0, 0, 0}, {1, 1, 1}, Fit::kSquareContext, filter, 1.0}, out.crops.data());

  project(input.points.data(), out.marks.size(), input.camera, Eigen::Matrix4d::Identity(),
          out.projected.data(), out.marks.data());

  const double angles[] = {-0.01, 0, 0.01}, ranges[] = {2, 2, 2};
  Eigen::Matrix4d T;
  T << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 1;
  Box box{};
  std::int32_t index = -1;
  candidate_boxes({ranges, angles, 3, 0.01}, input.camera, T, {0, 0, -0.3}, 160, 120,
                  {{1.0}, false, 0.0, true, 0.25}, &box, &index);
  out.boxes = {box.x0, box.y0, box.x1, box.y1, index};

  out.range_m = nearest_range(input.points.data(), 50, 0.01).range_m;
  raycast(input.points.data(), input.points.size() / 4, {10, 10, 0}, {0, 0.07, 90, 20}, out.ranges.data(),
          out.hits.data());
  return out;
}

}  // namespace

TEST_CASE("threads that work at once on the same input get what one alone gets") {
  const Input input;
  std::vector<Output> outputs(6);
  std::vector<std::thread> threads;
  for (Output& output : outputs)
    threads.emplace_back([&input, &output] {
      for (int i = 0; i < 10; ++i) output = run(input);
    });
  for (std::thread& thread : threads) thread.join();
  const Output alone = run(input);
  for (const Output& output : outputs) CHECK(output == alone);
}
