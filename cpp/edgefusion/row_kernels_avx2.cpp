// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// The only file with AVX2 intrinsics. Each function asks for AVX2 itself and is local to this file, so no
// AVX2 code can stand in for code that every machine must run. No fused multiply-add: its bits are not the
// generic code's.
#include "edgefusion/row_kernels_avx2.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

#define EDGEFUSION_AVX2 __attribute__((target("avx2")))

namespace edgefusion {
namespace {

EDGEFUSION_AVX2 inline __m256i load(const void* from) {
  return _mm256_loadu_si256(static_cast<const __m256i*>(from));
}

EDGEFUSION_AVX2 inline __m256i load_halves(const std::uint8_t* low, const std::uint8_t* high) {
  const __m256i both = _mm256_castsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(low)));
  return _mm256_inserti128_si256(both, _mm_loadu_si128(reinterpret_cast<const __m128i*>(high)), 1);
}

EDGEFUSION_AVX2 inline void store_channel(__m256i sums, const Affine& affine, int channel, float* out) {
  const __m256 scaled = _mm256_mul_ps(_mm256_cvtepi32_ps(sums), _mm256_set1_ps(affine.scale[channel]));
  _mm256_storeu_ps(out, _mm256_add_ps(scaled, _mm256_set1_ps(affine.offset[channel])));
}

// The pairs of four outputs, one channel after the other, out of the 16 bytes that hold them all.
EDGEFUSION_AVX2 void enlarge(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine,
                             float* rgb) {
  const int count = columns.count;
  const std::int32_t* offsets = columns.offsets.data();
  const std::uint8_t* shuffles = columns.shuffles.data();
  const std::int16_t* weights = columns.weights.data();
  for (int x = 0; x < count; x += FixedTaps::kBlock) {
    const __m256i pixels = load_halves(row + offsets[x], row + offsets[x + 4]);
    const __m256i blue = load(shuffles + 4 * x), w = load(weights + 2 * x);
    const __m256i green = _mm256_add_epi8(blue, _mm256_set1_epi8(1));  // kNone + 1 is none as well
    const __m256i red = _mm256_add_epi8(blue, _mm256_set1_epi8(2));
    store_channel(_mm256_madd_epi16(_mm256_shuffle_epi8(pixels, red), w), affine, 0, rgb + x);
    store_channel(_mm256_madd_epi16(_mm256_shuffle_epi8(pixels, green), w), affine, 1, rgb + count + x);
    store_channel(_mm256_madd_epi16(_mm256_shuffle_epi8(pixels, blue), w), affine, 2, rgb + 2 * count + x);
  }
}

// From B G R b g r in each half to the 16-bit pairs (B b) (G g) (R r), which one multiply-add weighs and
// sums.
EDGEFUSION_AVX2 inline __m256i weighed(__m256i pixels, __m256i weights) {
  const __m256i order = _mm256_setr_epi8(0, -1, 3, -1, 1, -1, 4, -1, 2, -1, 5, -1, -1, -1, -1, -1,  //
                                         0, -1, 3, -1, 1, -1, 4, -1, 2, -1, 5, -1, -1, -1, -1, -1);
  return _mm256_madd_epi16(_mm256_shuffle_epi8(pixels, order), weights);
}

// B, G, R and nothing of outputs k and k + 4 of a block, in the halves of of[k].
struct Sums {
  __m256i of[4];
};

EDGEFUSION_AVX2 inline Sums sum_pairs(const std::uint8_t* row, const std::int32_t* offsets,
                                      const std::int16_t* weights) {
  const __m256i w = load(weights);
  return {{weighed(load_halves(row + offsets[0], row + offsets[4]), _mm256_shuffle_epi32(w, 0x00)),
           weighed(load_halves(row + offsets[1], row + offsets[5]), _mm256_shuffle_epi32(w, 0x55)),
           weighed(load_halves(row + offsets[2], row + offsets[6]), _mm256_shuffle_epi32(w, 0xAA)),
           weighed(load_halves(row + offsets[3], row + offsets[7]), _mm256_shuffle_epi32(w, 0xFF))}};
}

EDGEFUSION_AVX2 inline void store_channels(const Sums& sums, const Affine& affine, float* rgb, int plane) {
  const __m256i bg01 = _mm256_unpacklo_epi32(sums.of[0], sums.of[1]);
  const __m256i bg23 = _mm256_unpacklo_epi32(sums.of[2], sums.of[3]);
  const __m256i r01 = _mm256_unpackhi_epi32(sums.of[0], sums.of[1]);
  const __m256i r23 = _mm256_unpackhi_epi32(sums.of[2], sums.of[3]);
  store_channel(_mm256_unpacklo_epi64(r01, r23), affine, 0, rgb);
  store_channel(_mm256_unpackhi_epi64(bg01, bg23), affine, 1, rgb + plane);
  store_channel(_mm256_unpacklo_epi64(bg01, bg23), affine, 2, rgb + 2 * plane);
}

// Any number of pairs, wherever they are.
EDGEFUSION_AVX2 void reduce(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine,
                            float* rgb) {
  const int count = columns.count;
  const std::int32_t* offsets = columns.offsets.data();
  for (int x = 0; x < count; x += FixedTaps::kBlock, offsets += FixedTaps::kBlock) {
    const std::int16_t* weights = columns.weights.data() + 2 * x;
    Sums sums = sum_pairs(row, offsets, weights);
    for (int pair = 1; pair < columns.pairs; ++pair) {
      weights += 2 * count;
      const Sums more = sum_pairs(row + 6 * pair, offsets, weights);
      for (int k = 0; k < 4; ++k) sums.of[k] = _mm256_add_epi32(sums.of[k], more.of[k]);
    }
    store_channels(sums, affine, rgb + x, count);
  }
}

EDGEFUSION_AVX2 void across(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine,
                            float* rgb) {
  if (columns.shuffles.empty())
    reduce(row, columns, affine, rgb);
  else
    enlarge(row, columns, affine, rgb);
}

EDGEFUSION_AVX2 void down(const float* const* rows, const float* weights, int n, int count, float* out) {
  int x = 0;
  for (; x + 8 <= count; x += 8) {
    __m256 sum = _mm256_mul_ps(_mm256_set1_ps(weights[0]), _mm256_loadu_ps(rows[0] + x));
    for (int t = 1; t < n; ++t)
      sum = _mm256_add_ps(sum, _mm256_mul_ps(_mm256_set1_ps(weights[t]), _mm256_loadu_ps(rows[t] + x)));
    _mm256_storeu_ps(out + x, sum);
  }
  for (; x < count; ++x) {
    out[x] = weights[0] * rows[0][x];
    for (int t = 1; t < n; ++t) out[x] += weights[t] * rows[t][x];
  }
}

}  // namespace

const RowKernels kAvx2Kernels{across, down};

}  // namespace edgefusion
#endif
