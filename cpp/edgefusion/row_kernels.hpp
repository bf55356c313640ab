// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>

#include "edgefusion/taps.hpp"

namespace edgefusion {

/// What turns the sum of an output pixel into a channel of the result.
struct Affine {
  float scale[3];  ///< RGB
  float offset[3];
};

/// The two loops that take the time of a crop. Every implementation gives the same bits.
struct RowKernels {
  /// One packed BGR row, resampled to three rows R, G, B of columns.count floats each: scale * sum + offset.
  ///
  /// Reads up to kSlack pixels behind the span's last one.
  void (*across)(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine, float* rgb);

  /// out[x] = sum over t < n of weights[t] * rows[t][x], for x < count, added up in this order.
  void (*down)(const float* const* rows, const float* weights, int n, int count, float* out);

  static constexpr int kSlack = 5;
};

/// Plain C++. Compilers make vectors of `down` at most: `across` gathers.
extern const RowKernels kGenericKernels;

/// Vector code of the machine that runs this, where there is some; else kGenericKernels.
const RowKernels& best_kernels();

}  // namespace edgefusion
