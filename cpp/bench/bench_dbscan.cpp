// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "edgefusion/dbscan.hpp"

using namespace edgefusion;

namespace {

using Points = std::vector<double>;

// A scan of 361 beams in a rectangular room, with the noise of a SICK LMS.
Points room_scan() {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.01);
  Points points;
  for (int beam = 0; beam < 361; ++beam) {
    const double angle = (beam - 180) * std::acos(-1.0) / 360.0;
    const double wall =
        std::min(6.0 / std::max(std::cos(angle), 1e-9), 4.0 / std::max(std::abs(std::sin(angle)), 1e-9));
    const double range = wall + noise(random);
    points.push_back(range * std::cos(angle));
    points.push_back(range * std::sin(angle));
  }
  return points;
}

// n points of constant density: `neighbours` of them lie within a distance of 1.
Points uniform(std::size_t n, double neighbours) {
  std::mt19937 random(1);
  const double area = static_cast<double>(n) * std::acos(-1.0) / neighbours;
  std::uniform_real_distribution<double> coordinate(0.0, std::sqrt(area));
  Points points(2 * n);
  for (double& value : points) value = coordinate(random);
  return points;
}

void cluster(benchmark::State& state, const Points& points, double eps) {
  std::vector<std::int32_t> labels(points.size() / 2);
  for (auto _ : state) {
    dbscan(points.data(), labels.size(), eps, 5, labels.data());
    benchmark::DoNotOptimize(labels.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(labels.size()));
}

void dbscan_room_scan(benchmark::State& state) {
  cluster(state, room_scan(), 0.3);
}
BENCHMARK(dbscan_room_scan);

void dbscan_uniform(benchmark::State& state) {
  cluster(state, uniform(static_cast<std::size_t>(state.range(0)), static_cast<double>(state.range(1))), 1.0);
}
BENCHMARK(dbscan_uniform)->ArgsProduct({{10000, 100000, 1000000}, {3, 12}})->ArgNames({"n", "neighbours"});

void dbscan_all_within_eps(benchmark::State& state) {
  Points points = uniform(static_cast<std::size_t>(state.range(0)), 1.0);
  const double extent = std::sqrt(static_cast<double>(state.range(0)) * std::acos(-1.0));
  cluster(state, points, 2.0 * extent);
}
BENCHMARK(dbscan_all_within_eps)->RangeMultiplier(10)->Range(10000, 1000000);

}  // namespace
