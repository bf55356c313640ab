// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/crops.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "edgefusion/cropper.hpp"
#include "edgefusion/row_kernels.hpp"

namespace edgefusion {
namespace {

void check(const CropOptions& options) {
  if (options.size < 1)
    throw std::invalid_argument("size: expected at least 1, got " + std::to_string(options.size));
  for (const float mean : options.mean)
    if (!std::isfinite(mean))
      throw std::invalid_argument("mean: expected finite, got " + std::to_string(mean));
  for (const float std : options.std)
    if (!(std::isfinite(std) && std > 0))
      throw std::invalid_argument("std: expected finite and above 0, got " + std::to_string(std));
  const double fraction = options.crop_fraction;
  if (!(fraction > 0 && fraction <= 1 && options.size / fraction < std::numeric_limits<int>::max()))
    throw std::invalid_argument("crop_fraction: expected in (0, 1], got " + std::to_string(fraction));
}

bool inside(const Box& box, const Image& image) {
  return box.x0 >= 0 && box.y0 >= 0 && box.x1 <= image.width && box.y1 <= image.height;
}

void check(const Box* boxes, std::size_t n, const Image& image) {
  for (std::size_t i = 0; i < n; ++i) {
    const Box& box = boxes[i];
    const bool empty = box.x0 >= box.x1 || box.y0 >= box.y1;
    if (!empty && inside(box, image)) continue;
    throw std::invalid_argument("boxes[" + std::to_string(i) + "]: (" + std::to_string(box.x0) + ", " +
                                std::to_string(box.y0) + ", " + std::to_string(box.x1) + ", " +
                                std::to_string(box.y1) + ") is " +
                                (empty ? "empty" : "not inside the image") + "; image " +
                                std::to_string(image.width) + " x " + std::to_string(image.height));
  }
}

}  // namespace

void crops(const Image& image, const Box* boxes, std::size_t n, const CropOptions& options, float* out) {
  check(options);
  check(boxes, n, image);
  const auto size = static_cast<std::size_t>(options.size);
  Cropper cropper(image, options, best_kernels());
  for (std::size_t i = 0; i < n; ++i) cropper.crop(boxes[i], out + i * 3 * size * size);
}

}  // namespace edgefusion
