// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "edgefusion/guard.hpp"
#include "edgefusion/manoeuvre.hpp"
#include "edgefusion/navigation_function.hpp"
#include "edgefusion/obstacle_map.hpp"
#include "edgefusion/raycast.hpp"

using namespace edgefusion;

namespace {

const double kPi = std::acos(-1.0);
constexpr double kCell = 0.05;
constexpr std::size_t kBeams = 361;

Footprint pioneer() {
  const double corners[] = {0.210, 0.2125, -0.301, 0.2125, -0.301, -0.2125, 0.210, -0.2125};
  return Footprint(corners, 4);
}

// Square things on either side of the middle, one on every 4 m^2.
std::vector<double> things(double side) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-side / 2, side / 2), half(0.05, 0.3);
  std::vector<double> segments;
  for (int k = 0; k < static_cast<int>(side * side / 4); ++k) {
    const double x = place(random), y = place(random), h = half(random);
    if (std::hypot(x, y) < 1.0) continue;
    segments.insert(segments.end(), {x - h, y - h, x + h, y - h, x + h, y - h, x + h, y + h});
    segments.insert(segments.end(), {x + h, y + h, x - h, y + h, x - h, y + h, x - h, y - h});
  }
  return segments;
}

// One turn of the laser in steps of half a degree, from where the base stands.
void look_around(ObstacleMap& map, const std::vector<double>& segments, double x, double y) {
  const Sweep sweep{-kPi, kPi / 360, 2 * kBeams - 2, 20.0};
  std::vector<double> ranges(sweep.n), poses;
  std::vector<std::int32_t> hits(sweep.n);
  raycast(segments.data(), segments.size() / 4, {x, y, 0.0}, sweep, ranges.data(), hits.data());
  const std::vector<float> singles(ranges.begin(), ranges.end());
  for (std::size_t i = 0; i < sweep.n; ++i) poses.insert(poses.end(), {x, y, 0.0});
  map.insert({poses.data(), singles.data(), sweep.n, sweep.angle_min, sweep.angle_increment, 0.0, 20.0}, 0);
}

// A window of this side, of which much was seen.
ObstacleMap explored(double side) {
  ObstacleMap map(kCell);
  const double edge = side / 2 - 7.5;
  map.cover(-edge, -edge, edge, edge);
  const std::vector<double> segments = things(side);
  for (double x = -side / 2; x <= side / 2; x += 3.0)
    for (double y = -side / 2; y <= side / 2; y += 3.0)
      for (int twice = 0; twice < 2; ++twice) look_around(map, segments, x, y);
  return map;
}

void obstacle_insert(benchmark::State& state) {
  ObstacleMap map = explored(15);
  const std::vector<double> segments = things(15);
  const Sweep sweep{-kPi / 2, kPi / 360, kBeams, 20.0};
  std::vector<double> ranges(kBeams), poses(3 * kBeams, 0.0);
  std::vector<std::int32_t> hits(kBeams);
  raycast(segments.data(), segments.size() / 4, {0.0, 0.0, 0.0}, sweep, ranges.data(), hits.data());
  const std::vector<float> singles(ranges.begin(), ranges.end());
  for (auto _ : state) {
    map.insert({poses.data(), singles.data(), kBeams, sweep.angle_min, sweep.angle_increment, 0.0, 20.0}, 0);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(obstacle_insert);

// The whole window, to a base in the farthest corner from the goal.
void navigation_function(benchmark::State& state) {
  const auto side = static_cast<double>(state.range(0));
  const ObstacleMap map = explored(side);
  const double corner = side / 2 - 1.0;
  NavigationFunction function({0.1925, 0.7125, 4.0});
  for (auto _ : state) {
    function.begin(map, -corner, -corner, 0.5, corner, corner);
    benchmark::DoNotOptimize(function.advance(map, map.window().size() * 4));
  }
  state.counters["cells"] = static_cast<double>(map.window().size());
}
BENCHMARK(navigation_function)->Arg(15)->Arg(60)->ArgName("metres")->Unit(benchmark::kMillisecond);

// Half a second ahead and the stop, among what is near.
void guard_free(benchmark::State& state) {
  const ObstacleMap map = explored(15);
  Guard guard(pioneer(), {0.3, 1.75});
  guard.look(map, 0.0, 0.0, 1.5, nullptr, 0);
  double w = 0.0;
  for (auto _ : state) {
    w = std::remainder(w + 0.01, 0.2);
    benchmark::DoNotOptimize(guard.free(map, {{0.0, 0.0, 0.0}, 0.3, 0.0}, {0.4, w}, 0.2, 0.02, 0.0));
  }
}
BENCHMARK(guard_free);

void guard_look(benchmark::State& state) {
  const ObstacleMap map = explored(15);
  Guard guard(pioneer(), {0.3, 1.75});
  for (auto _ : state) {
    guard.look(map, 0.0, 0.0, 1.5, nullptr, 0);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(guard_look);

// Out of a dead end too narrow to turn in, and, walled in, until all is tried.
void manoeuvre(benchmark::State& state) {
  const bool shut = state.range(0) != 0;
  ObstacleMap map(kCell);
  map.cover(-3.0, 0.0, 0.0, 0.0);
  std::vector<double> walls{-1.2, 0.3, 0.35, 0.3, -1.2, -0.3, 0.35, -0.3, 0.35, -0.3, 0.35, 0.3};
  if (shut) walls.insert(walls.end(), {-1.2, -0.3, -1.2, 0.3});
  for (const double x : {-2.0, -1.0, 0.0})
    for (int twice = 0; twice < 2; ++twice) look_around(map, walls, x, 0.0);
  NavigationFunction function({0.1925, 0.7125, 4.0});
  function.begin(map, -3.0, 0.0, 0.05, 0.0, 0.0);
  function.advance(map, map.window().size() * 4);
  Manoeuvre search(pioneer());
  for (auto _ : state) {
    search.begin(map, function.potential(), {0.0, 0.0, 0.0}, 0.01, {0.0, true, {-1.6, 0.0, kPi}, 0.1, 0.2},
                 nullptr, 0);
    search.advance(map, function.potential(), 1'000'000);
  }
  state.counters["legs"] = static_cast<double>(search.legs().size());
}
BENCHMARK(manoeuvre)->Arg(0)->Arg(1)->ArgName("shut")->Unit(benchmark::kMillisecond);

}  // namespace
