// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "edgefusion/cropper.hpp"

using namespace edgefusion;

namespace {

// One box of the paper's three shapes a round, from a camera of `width` x `height`.
void crop_boxes(benchmark::State& state, int width, int height, Filter filter, const RowKernels& kernels) {
  const int side = static_cast<int>(state.range(0));
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(3 * width * height));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 2654435761u >> 13);
  const Image image{bytes.data(), height, width, 3 * width, 3, 1};
  const CropOptions options{256, {0.485f, 0.456f, 0.406f}, {0.229f, 0.224f, 0.225f}, Fit::kSquash, filter, 1};
  std::vector<float> out(3 * 3 * 256 * 256);
  Cropper cropper(image, options, kernels);
  for (auto _ : state) {
    float* to = out.data();
    for (const double shape : {0.6, 1.0, 1.6}) {
      cropper.crop({100, 100, 100 + side, 100 + static_cast<int>(side * shape)}, to);
      to += 3 * 256 * 256;
    }
    benchmark::ClobberMemory();
  }
}

void antialias(benchmark::State& state) {
  crop_boxes(state, 1280, 720, Filter::kAntialias, best_kernels());
}
void antialias_generic(benchmark::State& state) {
  crop_boxes(state, 1280, 720, Filter::kAntialias, kGenericKernels);
}
void linear(benchmark::State& state) {
  crop_boxes(state, 1280, 720, Filter::kLinear, best_kernels());
}
void linear_generic(benchmark::State& state) {
  crop_boxes(state, 1280, 720, Filter::kLinear, kGenericKernels);
}
void antialias_large(benchmark::State& state) {
  crop_boxes(state, 2592, 1944, Filter::kAntialias, best_kernels());
}
void linear_large(benchmark::State& state) {
  crop_boxes(state, 2592, 1944, Filter::kLinear, best_kernels());
}

}  // namespace

BENCHMARK(antialias)->Arg(100)->Arg(200)->Arg(300);
BENCHMARK(antialias_generic)->Arg(200);
BENCHMARK(linear)->Arg(100)->Arg(200)->Arg(300);
BENCHMARK(linear_generic)->Arg(200);
BENCHMARK(antialias_large)->Arg(1100);
BENCHMARK(linear_large)->Arg(1100);
