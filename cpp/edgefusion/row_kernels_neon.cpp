// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// The only file with NEON intrinsics, and only such as gcc 7.5 has. No fused multiply-add of floats: its bits
// are not the generic code's.
#include "edgefusion/row_kernels_neon.hpp"

#if defined(__aarch64__)
#include <arm_neon.h>

namespace edgefusion {
namespace {

constexpr int kLanes = 4;  // outputs made at a time; divides FixedTaps::kBlock

// Affine in registers, so that no store makes the compiler load it again.
struct Scaling {
  explicit Scaling(const Affine& affine)
      : scale{vdupq_n_f32(affine.scale[0]), vdupq_n_f32(affine.scale[1]), vdupq_n_f32(affine.scale[2])},
        offset{vdupq_n_f32(affine.offset[0]), vdupq_n_f32(affine.offset[1]), vdupq_n_f32(affine.offset[2])} {}

  void store(int32x4_t sums, int channel, float* out) const {
    const float32x4_t scaled = vmulq_f32(vcvtq_f32_s32(sums), scale[channel]);
    vst1q_f32(out, vaddq_f32(scaled, offset[channel]));
  }

  float32x4_t scale[3], offset[3];
};

// One channel of four outputs: each byte becomes 16 bits, and its pair's products are added up.
inline int32x4_t sum_channel(uint8x16_t pixels, uint8x16_t places, int16x8_t weights) {
  const int16x8_t channel = vreinterpretq_s16_u8(vqtbl1q_u8(pixels, places));
  return vpaddq_s32(vmull_s16(vget_low_s16(channel), vget_low_s16(weights)),
                    vmull_high_s16(channel, weights));
}

// The pairs of four outputs, one channel after the other, out of the 16 bytes that hold them all.
void enlarge(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine, float* rgb) {
  const Scaling scaling(affine);
  const int count = columns.count;
  const std::int32_t* offsets = columns.offsets.data();
  const std::uint8_t* shuffles = columns.shuffles.data();
  const std::int16_t* weights = columns.weights.data();
  for (int x = 0; x < count; x += kLanes) {
    const uint8x16_t pixels = vld1q_u8(row + offsets[x]), blue = vld1q_u8(shuffles + 4 * x);
    const uint8x16_t green = vaddq_u8(blue, vdupq_n_u8(1));  // kNone + 1 is none as well
    const uint8x16_t red = vaddq_u8(blue, vdupq_n_u8(2));
    const int16x8_t w = vld1q_s16(weights + 2 * x);
    scaling.store(sum_channel(pixels, red, w), 0, rgb + x);
    scaling.store(sum_channel(pixels, green, w), 1, rgb + count + x);
    scaling.store(sum_channel(pixels, blue, w), 2, rgb + 2 * count + x);
  }
}

// Adds one pair of one output, B G R b g r at `bgr`, to its sums B, G, R and nothing.
template <int kOutput>
inline int32x4_t add_pair(int32x4_t sums, const std::uint8_t* bgr, uint8x16_t order, int16x8_t weights) {
  const int16x8_t pixels = vreinterpretq_s16_u8(vqtbl1q_u8(vld1q_u8(bgr), order));
  sums = vmlal_laneq_s16(sums, vget_low_s16(pixels), weights, 2 * kOutput);
  return vmlal_high_laneq_s16(sums, pixels, weights, 2 * kOutput + 1);
}

inline int32x4_t join(int32x4_t low, int32x4_t high) {
  return vcombine_s32(vget_low_s32(low), vget_low_s32(high));
}

// Any number of pairs, wherever they are.
void reduce(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine, float* rgb) {
  constexpr std::uint8_t kNone = FixedTaps::kNone;
  constexpr std::uint8_t kOrder[16] = {0, kNone, 1, kNone, 2, kNone, kNone, kNone,
                                       3, kNone, 4, kNone, 5, kNone, kNone, kNone};
  const uint8x16_t order = vld1q_u8(kOrder);
  const Scaling scaling(affine);
  const int count = columns.count;
  const std::int32_t* offsets = columns.offsets.data();
  for (int x = 0; x < count; x += kLanes, offsets += kLanes) {
    const std::int16_t* weights = columns.weights.data() + 2 * x;
    int32x4_t sums0 = vdupq_n_s32(0), sums1 = sums0, sums2 = sums0, sums3 = sums0;
    const std::uint8_t* bgr = row;
    for (int pair = 0; pair < columns.pairs; ++pair, bgr += 6, weights += 2 * count) {
      const int16x8_t w = vld1q_s16(weights);
      sums0 = add_pair<0>(sums0, bgr + offsets[0], order, w);
      sums1 = add_pair<1>(sums1, bgr + offsets[1], order, w);
      sums2 = add_pair<2>(sums2, bgr + offsets[2], order, w);
      sums3 = add_pair<3>(sums3, bgr + offsets[3], order, w);
    }
    const int32x4_t bg01 = vzip1q_s32(sums0, sums1), bg23 = vzip1q_s32(sums2, sums3);
    const int32x4_t r01 = vzip2q_s32(sums0, sums1), r23 = vzip2q_s32(sums2, sums3);
    scaling.store(join(r01, r23), 0, rgb + x);
    scaling.store(vcombine_s32(vget_high_s32(bg01), vget_high_s32(bg23)), 1, rgb + count + x);
    scaling.store(join(bg01, bg23), 2, rgb + 2 * count + x);
  }
}

void across(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine, float* rgb) {
  if (columns.shuffles.empty())
    reduce(row, columns, affine, rgb);
  else
    enlarge(row, columns, affine, rgb);
}

// Sixteen sums stay in registers, where the compiler's own vectors go through memory for each row.
void down(const float* const* rows, const float* weights, int n, int count, float* out) {
  int x = 0;
  for (; x + 16 <= count; x += 16) {
    float32x4_t sum[4];
    for (int k = 0; k < 4; ++k) sum[k] = vmulq_n_f32(vld1q_f32(rows[0] + x + 4 * k), weights[0]);
    for (int t = 1; t < n; ++t)
      for (int k = 0; k < 4; ++k)
        sum[k] = vaddq_f32(sum[k], vmulq_n_f32(vld1q_f32(rows[t] + x + 4 * k), weights[t]));
    for (int k = 0; k < 4; ++k) vst1q_f32(out + x + 4 * k, sum[k]);
  }
  for (; x < count; ++x) {
    out[x] = weights[0] * rows[0][x];
    for (int t = 1; t < n; ++t) out[x] += weights[t] * rows[t][x];
  }
}

}  // namespace

const RowKernels kNeonKernels{across, down};

}  // namespace edgefusion
#endif
