// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// The only file with intrinsics. Each function asks for AVX2 itself, so the rest of the binary runs anywhere;
// none is inline or calls one that is, so none of its code can stand in for code that every machine must run.
// No fused multiply-add: it would give other bits than the generic code.
#include "edgefusion/row_kernels_avx2.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

#define EDGEFUSION_AVX2 __attribute__((target("avx2")))

namespace edgefusion {
namespace {

// Two neighbouring pixels of output i in the low half, of output i + 4 in the high half.
EDGEFUSION_AVX2 inline __m256i load_pixels(const std::uint8_t* row, const std::int32_t* offsets, int i) {
  const __m128i low = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(row + offsets[i]));
  const __m128i high = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(row + offsets[i + 4]));
  return _mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1);
}

// From B G R b g r to the 16-bit pairs (B b) (G g) (R r), which one multiply-add weighs and sums.
EDGEFUSION_AVX2 inline __m256i paired(__m256i pixels) {
  const __m256i order = _mm256_setr_epi8(0, -1, 3, -1, 1, -1, 4, -1, 2, -1, 5, -1, -1, -1, -1, -1,  //
                                         0, -1, 3, -1, 1, -1, 4, -1, 2, -1, 5, -1, -1, -1, -1, -1);
  return _mm256_shuffle_epi8(pixels, order);
}

EDGEFUSION_AVX2 inline void store_channel(__m256i sums, const Affine& affine, int channel, float* out) {
  const __m256 scaled = _mm256_mul_ps(_mm256_cvtepi32_ps(sums), _mm256_set1_ps(affine.scale[channel]));
  _mm256_storeu_ps(out, _mm256_add_ps(scaled, _mm256_set1_ps(affine.offset[channel])));
}

EDGEFUSION_AVX2 void across(const std::uint8_t* row, const FixedTaps& columns, const Affine& affine,
                            float* rgb) {
  const int count = columns.count;
  const std::int32_t* offsets = columns.offsets.data();
  const std::int16_t* block = columns.weights.data();
  for (int x = 0; x < count; x += FixedTaps::kBlock, offsets += FixedTaps::kBlock, block += 16, rgb += 8) {
    __m256i sum0 = _mm256_setzero_si256(), sum1 = sum0, sum2 = sum0,
            sum3 = sum0;  // B G R of outputs i, i + 4
    const std::int16_t* weights = block;
    for (int pair = 0; pair < columns.pairs; ++pair, weights += 2 * count) {
      const __m256i w = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(weights));
      const std::uint8_t* from = row + 6 * pair;
      const __m256i p0 = paired(load_pixels(from, offsets, 0)), p1 = paired(load_pixels(from, offsets, 1));
      const __m256i p2 = paired(load_pixels(from, offsets, 2)), p3 = paired(load_pixels(from, offsets, 3));
      sum0 = _mm256_add_epi32(sum0, _mm256_madd_epi16(p0, _mm256_shuffle_epi32(w, 0x00)));
      sum1 = _mm256_add_epi32(sum1, _mm256_madd_epi16(p1, _mm256_shuffle_epi32(w, 0x55)));
      sum2 = _mm256_add_epi32(sum2, _mm256_madd_epi16(p2, _mm256_shuffle_epi32(w, 0xAA)));
      sum3 = _mm256_add_epi32(sum3, _mm256_madd_epi16(p3, _mm256_shuffle_epi32(w, 0xFF)));
    }
    const __m256i bg01 = _mm256_unpacklo_epi32(sum0, sum1), bg23 = _mm256_unpacklo_epi32(sum2, sum3);
    const __m256i r01 = _mm256_unpackhi_epi32(sum0, sum1), r23 = _mm256_unpackhi_epi32(sum2, sum3);
    store_channel(_mm256_unpacklo_epi64(r01, r23), affine, 0, rgb);
    store_channel(_mm256_unpackhi_epi64(bg01, bg23), affine, 1, rgb + count);
    store_channel(_mm256_unpacklo_epi64(bg01, bg23), affine, 2, rgb + 2 * count);
  }
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
