// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/window.hpp"

#include <algorithm>
#include <cmath>

namespace edgefusion {
namespace {

using Int = std::int64_t;

// numerator / denominator, halves up; both above or equal to 0.
Int rounded(Int numerator, Int denominator) {
  return (2 * numerator + denominator) / (2 * denominator);
}

// As Python rounds half of a number, which is what torchvision's CenterCrop does.
Int half_to_even(Int n) {
  return n / 2 + (n % 2) * (n / 2 % 2);
}

AxisSpan squashed(int source, int length, int size) {
  return {source, length, size, 0, 0, size};
}

AxisSpan letterboxed(int source, int length, int longer, int size) {
  const auto count = static_cast<int>(std::max<Int>(1, rounded(Int{length} * size, longer)));
  return {source, length, count, 0, (size - count) / 2, count};
}

AxisSpan with_context(int source, int length, int side, int image, int size) {
  const int centred = source - (side - length) / 2;
  const int start = std::clamp(centred, std::min(0, image - side), std::max(0, image - side));
  const int first = std::max(0, start);
  const int last = std::min(image, start + side);
  const auto at = static_cast<int>(std::min<Int>(size - 1, rounded(Int{first - start} * size, side)));
  const auto end = static_cast<int>(rounded(Int{last - start} * size, side));
  const int count = std::max(1, end - at);
  return {first, last - first, count, 0, at, count};
}

AxisSpan centred(int source, int length, int shorter, Int resized_shorter, int size) {
  const Int resized = resized_shorter * length / shorter;
  return {source, length, resized, half_to_even(resized - size), 0, size};
}

}  // namespace

Window window_of(const Box& box, const Image& image, const CropOptions& options) {
  const int w = box.width(), h = box.height(), size = options.size;
  const int longer = std::max(w, h), shorter = std::min(w, h);
  switch (options.fit) {
    case Fit::kLetterbox:
      return {letterboxed(box.x0, w, longer, size), letterboxed(box.y0, h, longer, size)};
    case Fit::kSquareContext:
      return {with_context(box.x0, w, longer, image.width, size),
              with_context(box.y0, h, longer, image.height, size)};
    case Fit::kShorterSideCentre: {
      const Int resized = std::llrint(size / options.crop_fraction);
      return {centred(box.x0, w, shorter, resized, size), centred(box.y0, h, shorter, resized, size)};
    }
    case Fit::kSquash:
      break;
  }
  return {squashed(box.x0, w, size), squashed(box.y0, h, size)};
}

}  // namespace edgefusion
