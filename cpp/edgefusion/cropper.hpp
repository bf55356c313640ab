// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>
#include <vector>

#include "edgefusion/crops.hpp"
#include "edgefusion/row_kernels.hpp"
#include "edgefusion/taps.hpp"
#include "edgefusion/window.hpp"

namespace edgefusion {

/// Resamples windows of one image; its buffers are reused from crop to crop.
class Cropper {
 public:
  Cropper(const Image& image, const CropOptions& options, const RowKernels& kernels);

  /// Writes the whole 3 x size x size of `out`.
  void crop(const Box& box, float* out);

 private:
  void resample(const Window& window, float* out);
  const std::uint8_t* packed_row(const Window& window, int y);
  float* ring_row(int y);

  const Image image_;
  const CropOptions options_;
  const RowKernels& kernels_;
  Taps taps_x_, taps_y_;
  FixedTaps columns_;
  std::vector<std::uint8_t> packed_;  // a row that cannot be read in place
  std::vector<float> ring_;           // the resampled rows that the taps of one output row reach
  std::vector<const float*> rows_;
};

}  // namespace edgefusion
