// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/taps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edgefusion {
namespace {

void resize(Taps& taps, int count, int width) {
  taps.width = width;
  taps.first.resize(static_cast<std::size_t>(count));
  taps.weights.resize(static_cast<std::size_t>(count) * static_cast<std::size_t>(width));
}

// Pillow's: each output is a triangle about its centre, as wide as two outputs or, enlarging, two pixels.
void make_triangles(const AxisSpan& span, Taps& taps) {
  const double scale = static_cast<double>(span.length) / static_cast<double>(span.resized);
  const double support = std::max(1.0, scale);
  const double slope = 1 / support;
  const int width = static_cast<int>(std::min<double>(span.length, std::ceil(2 * support)));
  resize(taps, span.count, width);
  float* weights = taps.weights.data();
  for (int i = 0; i < span.count; ++i, weights += width) {
    const double centre = (static_cast<double>(span.skipped + i) + 0.5) * scale;
    const int first = std::clamp(static_cast<int>(centre - support + 0.5), 0, span.length - width);
    double sum = 0;
    for (int t = 0; t < width; ++t) {
      const double weight = std::max(0.0, 1 - std::abs(first + t + 0.5 - centre) * slope);
      weights[t] = static_cast<float>(weight);
      sum += weight;
    }
    const double whole = 1 / sum;
    for (int t = 0; t < width; ++t) weights[t] = static_cast<float>(weights[t] * whole);
    taps.first[static_cast<std::size_t>(i)] = first;
  }
}

// OpenCV's: between the two nearest pixels, whatever the scale; beyond the outermost centre the edge goes on.
void make_linear(const AxisSpan& span, Taps& taps) {
  const double scale = static_cast<double>(span.length) / static_cast<double>(span.resized);
  const int width = std::min(span.length, 2);
  resize(taps, span.count, width);
  float* weights = taps.weights.data();
  for (int i = 0; i < span.count; ++i, weights += width) {
    const double centre = (static_cast<double>(span.skipped + i) + 0.5) * scale - 0.5;
    const double inside = std::clamp(centre, 0.0, span.length - 1.0);
    const int first = std::min(static_cast<int>(inside), span.length - width);
    const double second = inside - first;
    weights[0] = static_cast<float>(1 - second);
    if (width == 2) weights[1] = static_cast<float>(second);
    taps.first[static_cast<std::size_t>(i)] = first;
  }
}

// Binary places such that every weight fits 16 bits and a sum of 255s fits 32.
int places_for(float largest) {
  constexpr int kMost = 22;
  const float room = static_cast<float>(std::numeric_limits<std::int16_t>::max() - 1);
  int places = 14;
  while (places < kMost && std::ldexp(largest, places + 1) < room) ++places;
  return places;
}

// The running sum is rounded, not each weight: they add up to exactly one, so a flat image stays flat.
void round_weights(const float* weights, int width, int places, std::int16_t* fixed,
                   std::size_t pair_stride) {
  const float one = std::ldexp(1.0f, places);
  float sum = 0;
  int before = 0;
  for (int t = 0; t < width; ++t) {
    sum += weights[t];
    const int now = static_cast<int>(t + 1 < width ? sum * one + 0.5f : one);
    fixed[static_cast<std::size_t>(t / 2) * pair_stride + static_cast<std::size_t>(t % 2)] =
        static_cast<std::int16_t>(now - before);
    before = now;
  }
}

bool share_16_bytes(const FixedTaps& fixed) {
  constexpr int kReach = 3 * 3;  // that of the last of four outputs, whose pair ends within 6 bytes
  if (fixed.pairs > 1) return false;
  for (std::size_t i = 0; i < fixed.offsets.size(); i += 4)
    if (fixed.offsets[i + 3] - fixed.offsets[i] > kReach) return false;
  return true;
}

void make_shuffles(FixedTaps& fixed) {
  fixed.shuffles.clear();
  if (!share_16_bytes(fixed)) return;
  fixed.shuffles.resize(4 * fixed.offsets.size(), FixedTaps::kNone);
  for (std::size_t i = 0; i < fixed.offsets.size(); ++i) {
    const auto place = static_cast<std::uint8_t>(fixed.offsets[i] - fixed.offsets[i - i % 4]);
    fixed.shuffles[4 * i] = place;
    fixed.shuffles[4 * i + 2] = static_cast<std::uint8_t>(place + 3);
  }
}

}  // namespace

void make_taps(const AxisSpan& span, Filter filter, Taps& taps) {
  if (filter == Filter::kAntialias)
    make_triangles(span, taps);
  else
    make_linear(span, taps);
}

void make_fixed(const Taps& taps, FixedTaps& fixed) {
  const std::size_t outputs = taps.first.size();
  const std::size_t count = (outputs + FixedTaps::kBlock - 1) / FixedTaps::kBlock * FixedTaps::kBlock;
  const auto width = static_cast<std::size_t>(taps.width);
  const int places = places_for(*std::max_element(taps.weights.begin(), taps.weights.end()));
  fixed.count = static_cast<int>(count);
  fixed.pairs = (taps.width + 1) / 2;
  fixed.unit = std::ldexp(1.0f, -places);
  fixed.offsets.assign(count, 3 * taps.first.back());
  fixed.weights.assign(static_cast<std::size_t>(fixed.pairs) * count * 2, 0);
  for (std::size_t i = 0; i < outputs; ++i) {
    fixed.offsets[i] = 3 * taps.first[i];
    round_weights(&taps.weights[i * width], taps.width, places, &fixed.weights[2 * i], 2 * count);
  }
  make_shuffles(fixed);
}

}  // namespace edgefusion
