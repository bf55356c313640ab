// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/cropper.hpp"

#include <algorithm>
#include <cstring>

namespace edgefusion {
namespace {

constexpr int kChannels = 3;

Affine normalization(const CropOptions& options, double unit) {
  Affine affine{};
  for (int c = 0; c < kChannels; ++c) {
    const double std = options.std[static_cast<std::size_t>(c)];
    affine.scale[c] = static_cast<float>(unit / (255 * std));
    affine.offset[c] = static_cast<float>(-options.mean[static_cast<std::size_t>(c)] / std);
  }
  return affine;
}

bool fills_square(const Window& window, int size) {
  return window.x.count == size && window.y.count == size;
}

}  // namespace

Cropper::Cropper(const Image& image, const CropOptions& options, const RowKernels& kernels)
    : image_(image), options_(options), kernels_(kernels) {}

void Cropper::crop(const Box& box, float* out) {
  const Window window = window_of(box, image_, options_);
  const auto square = static_cast<std::size_t>(options_.size) * static_cast<std::size_t>(options_.size);
  // Padding is the mean colour, which normalization makes 0.
  if (!fills_square(window, options_.size)) std::fill_n(out, kChannels * square, 0.0f);
  make_taps(window.x, options_.filter, taps_x_);
  make_fixed(taps_x_, columns_);
  make_taps(window.y, options_.filter, taps_y_);
  resample(window, out);
}

// Across first, once per source row; the rows that one output row needs wait in a ring that fits the cache.
void Cropper::resample(const Window& window, float* out) {
  const auto size = static_cast<std::size_t>(options_.size);
  const Affine affine = normalization(options_, columns_.unit);
  const int taps = taps_y_.width;
  ring_.resize(static_cast<std::size_t>(taps) * kChannels * static_cast<std::size_t>(columns_.count));
  rows_.resize(static_cast<std::size_t>(taps));
  int next = 0;
  for (int i = 0; i < window.y.count; ++i) {
    const int first = taps_y_.first[static_cast<std::size_t>(i)];
    for (next = std::max(next, first); next < first + taps; ++next)
      kernels_.across(packed_row(window, next), columns_, affine, ring_row(next));
    const float* weights = &taps_y_.weights[static_cast<std::size_t>(i * taps)];
    float* to = out + static_cast<std::size_t>(window.y.at + i) * size + window.x.at;
    for (int c = 0; c < kChannels; ++c, to += size * size) {
      for (int t = 0; t < taps; ++t)
        rows_[static_cast<std::size_t>(t)] = ring_row(first + t) + c * columns_.count;
      kernels_.down(rows_.data(), weights, taps, window.x.count, to);
    }
  }
}

float* Cropper::ring_row(int y) {
  return &ring_[static_cast<std::size_t>(y % taps_y_.width) * kChannels *
                static_cast<std::size_t>(columns_.count)];
}

// The kernels want packed BGR and read a little behind the window: where the image is laid out otherwise, or
// ends there, they get a copy of the row.
const std::uint8_t* Cropper::packed_row(const Window& window, int y) {
  const AxisSpan& x = window.x;
  const std::uint8_t* first =
      image_.data + (window.y.source + y) * image_.row_stride + x.source * image_.pixel_stride;
  const bool packed = image_.channel_stride == 1 && image_.pixel_stride == kChannels;
  if (packed && x.source + x.length + RowKernels::kSlack <= image_.width) return first;
  packed_.resize(static_cast<std::size_t>(kChannels * (x.length + RowKernels::kSlack)));
  std::uint8_t* to = packed_.data();
  if (packed) {
    std::memcpy(to, first, static_cast<std::size_t>(kChannels * x.length));
    return to;
  }
  for (int i = 0; i < x.length; ++i, first += image_.pixel_stride)
    for (int c = 0; c < kChannels; ++c) *to++ = first[c * image_.channel_stride];
  return packed_.data();
}

}  // namespace edgefusion
