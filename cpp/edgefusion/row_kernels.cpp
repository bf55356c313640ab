// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/row_kernels.hpp"

#include "edgefusion/cpu.hpp"
#include "edgefusion/row_kernels_avx2.hpp"
#include "edgefusion/row_kernels_neon.hpp"

namespace edgefusion {
namespace {

void across(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine, float* rgb) {
  const int count = columns.count;
  for (int x = 0; x < count; ++x) {
    const std::uint8_t* bgr = row + columns.offsets[static_cast<std::size_t>(x)];
    const std::int16_t* weights = &columns.weights[static_cast<std::size_t>(2 * x)];
    std::int32_t b = 0, g = 0, r = 0;
    for (int pair = 0; pair < columns.pairs; ++pair, bgr += 6, weights += 2 * count) {
      b += weights[0] * bgr[0] + weights[1] * bgr[3];
      g += weights[0] * bgr[1] + weights[1] * bgr[4];
      r += weights[0] * bgr[2] + weights[1] * bgr[5];
    }
    rgb[x] = static_cast<float>(r) * affine.scale[0] + affine.offset[0];
    rgb[count + x] = static_cast<float>(g) * affine.scale[1] + affine.offset[1];
    rgb[2 * count + x] = static_cast<float>(b) * affine.scale[2] + affine.offset[2];
  }
}

void down(const float* const* rows, const float* weights, int n, int count, float* out) {
  for (int x = 0; x < count; ++x) out[x] = weights[0] * rows[0][x];
  for (int t = 1; t < n; ++t)
    for (int x = 0; x < count; ++x) out[x] += weights[t] * rows[t][x];
}

}  // namespace

const RowKernels kGenericKernels{across, down};

const RowKernels& best_kernels() {
#if defined(__aarch64__)
  return kNeonKernels;
#else
#if defined(__x86_64__)
  if (cpu_has_avx2()) return kAvx2Kernels;
#endif
  return kGenericKernels;
#endif
}

}  // namespace edgefusion
