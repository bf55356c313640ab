// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "edgefusion/raycast.hpp"

using namespace edgefusion;

namespace {

const double kPi = std::acos(-1.0);

// A room of 12 m x 12 m with round and boxy things, each outline of 16 segments.
std::vector<double> room(std::size_t outlines) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-6.0, 6.0), radius(0.03, 0.5);
  std::vector<double> segments{-6, -6, 6, -6, 6, -6, 6, 6, 6, 6, -6, 6, -6, 6, -6, -6};
  for (std::size_t k = 0; k < outlines; ++k) {
    const double x = place(random), y = place(random), r = radius(random);
    if (std::hypot(x, y) < r + 0.3) continue;
    for (int i = 0; i < 16; ++i)
      for (const int corner : {i, i + 1}) {
        segments.push_back(x + r * std::cos(kPi / 8 * (corner % 16)));
        segments.push_back(y + r * std::sin(kPi / 8 * (corner % 16)));
      }
  }
  return segments;
}

void raycast_room(benchmark::State& state) {
  const std::vector<double> segments = room(static_cast<std::size_t>(state.range(0)) / 16);
  std::vector<double> ranges(361);
  std::vector<std::int32_t> hits(361);
  LaserPose pose{0.1, 0.05, 0.0};
  for (auto _ : state) {
    pose.theta += 0.01;
    raycast(segments.data(), segments.size() / 4, pose, {-kPi / 2, kPi / 360, 361, 8.0}, ranges.data(),
            hits.data());
    benchmark::DoNotOptimize(ranges.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(raycast_room)->Arg(0)->Arg(1000)->Arg(2000)->ArgName("segments");

}  // namespace
