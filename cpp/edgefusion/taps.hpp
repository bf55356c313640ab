// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>
#include <vector>

#include "edgefusion/crops.hpp"
#include "edgefusion/window.hpp"

namespace edgefusion {

/// Which source pixels make up each output pixel of one axis, and by how much.
///
/// Output i is the sum over t < width of weights[i * width + t] * source[first[i] + t]; the weights add up to
/// 1, first never falls, and first + width never goes past the span.
struct Taps {
  int width = 0;
  std::vector<int> first;
  std::vector<float> weights;
};

/// Taps of the pixels that `span` keeps. `taps` is written, its memory reused.
void make_taps(const AxisSpan& span, Filter filter, Taps& taps);

/// The same in 16-bit fixed point, for pairs of neighbouring pixels of a packed BGR row.
///
/// Padded to a whole number of blocks of outputs, whose weights are 0. An odd width is padded too, so up to
/// one pixel behind the span is read, and weighs nothing.
struct FixedTaps {
  static constexpr int kBlock = 8;  ///< outputs that a vector kernel makes at a time

  int count = 0;                      ///< outputs, a multiple of kBlock
  int pairs = 0;                      ///< pairs of taps of each output
  float unit = 0;                     ///< what a sum has to be multiplied by
  std::vector<std::int32_t> offsets;  ///< of each output: bytes from the span's first pixel to the first tap
  std::vector<std::int16_t> weights;  ///< [pairs][count][2]

  /// Where images are enlarged, four outputs find their only pairs in the same 16 bytes. Of each output: the
  /// places of its two blue bytes, counted from the first of the four, each followed by kNone. Else empty.
  std::vector<std::uint8_t> shuffles;
  static constexpr std::uint8_t kNone = 0x80;
};

/// `fixed` is written, its memory reused.
void make_fixed(const Taps& taps, FixedTaps& fixed);

}  // namespace edgefusion
