// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/crops.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "edgefusion/cropper.hpp"
#include "edgefusion/refuse.hpp"
#include "edgefusion/row_kernels.hpp"

namespace edgefusion {
namespace {

void check(const CropOptions& options) {
  if (options.size < 1) refuse("size: expected at least 1, got ", options.size);
  for (const float mean : options.mean)
    if (!std::isfinite(mean)) refuse("mean: expected finite numbers, got ", mean);
  for (const float std : options.std)
    if (!(std::isfinite(std) && std > 0)) refuse("std: expected finite numbers above 0, got ", std);
  const double fraction = options.crop_fraction;
  if (!(fraction > 0 && fraction <= 1 && options.size / fraction < std::numeric_limits<int>::max()))
    refuse("crop_fraction: expected above 0 and at most 1, got ", fraction);
}

void check(const Image& image) {
  if (std::max(image.width, image.height) > kMaxImageSide)
    refuse("image: expected at most ", kMaxImageSide, " pixels a side, got ", image.width, " x ",
           image.height);
}

bool inside(const Box& box, const Image& image) {
  return box.x0 >= 0 && box.y0 >= 0 && box.x1 <= image.width && box.y1 <= image.height;
}

void check(const Box* boxes, std::size_t n, const Image& image) {
  for (std::size_t i = 0; i < n; ++i) {
    const Box& box = boxes[i];
    const bool empty = box.x0 >= box.x1 || box.y0 >= box.y1;
    if (!empty && inside(box, image)) continue;
    refuse("boxes[", i, "]: (", box.x0, ", ", box.y0, ", ", box.x1, ", ", box.y1, ") is ",
           empty ? "empty" : "not inside the image", "; image ", image.width, " x ", image.height);
  }
}

}  // namespace

void crops(const Image& image, const Box* boxes, std::size_t n, const CropOptions& options, float* out) {
  check(options);
  check(image);
  check(boxes, n, image);
  const auto size = static_cast<std::size_t>(options.size);
  Cropper cropper(image, options, best_kernels());
  for (std::size_t i = 0; i < n; ++i) cropper.crop(boxes[i], out + i * 3 * size * size);
}

}  // namespace edgefusion
