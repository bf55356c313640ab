// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "edgefusion/box.hpp"

namespace edgefusion {

/// How a box of any shape becomes a square; to the pixel in window.hpp.
enum class Fit {
  kSquash,             ///< stretched to the square (the paper)
  kLetterbox,          ///< whole box, its shape kept, padded with the mean colour
  kSquareContext,      ///< the square around the box, moved inside the image; padded where it cannot fit
  kShorterSideCentre,  ///< shorter side resized to size / crop_fraction, then the centre (torchvision)
};

enum class Filter {
  kAntialias,  ///< triangle whose support grows with the reduction: Pillow's BILINEAR
  kLinear,     ///< between the four nearest pixels: OpenCV's INTER_LINEAR
};

/// Bytes of a row are counted in an int.
constexpr int kMaxImageSide = 1 << 28;

/// A view of an image of 8-bit BGR pixels, at most kMaxImageSide a side; strides in bytes, also negative.
struct Image {
  const std::uint8_t* data;
  int height, width;
  std::ptrdiff_t row_stride, pixel_stride, channel_stride;
};

struct CropOptions {
  int size;                   ///< side of the square, pixels
  std::array<float, 3> mean;  ///< RGB, of values 0..1
  std::array<float, 3> std;   ///< RGB
  Fit fit;
  Filter filter;
  double crop_fraction;  ///< for kShorterSideCentre, in (0, 1]
};

/// Crop, resize, BGR to RGB and (value / 255 - mean) / std of n boxes, in one pass each.
///
/// out  n x 3 x size x size, written
///
/// Throws std::invalid_argument, naming the box, for an empty one or one that is not inside the image, and
/// for a larger image, size < 1, a mean that is not finite, a std not finite and above 0 or a crop_fraction
/// outside (0, 1].
void crops(const Image& image, const Box* boxes, std::size_t n, const CropOptions& options, float* out);

}  // namespace edgefusion
