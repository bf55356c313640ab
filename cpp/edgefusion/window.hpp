// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstdint>

#include "edgefusion/crops.hpp"

namespace edgefusion {

/// One axis of a crop: `length` source pixels are resized to `resized`, of which `count` are kept.
struct AxisSpan {
  int source;            ///< first source pixel, in the image
  int length;            ///< source pixels; none outside them is ever read
  std::int64_t resized;  ///< pixels that `length` would be resized to
  std::int64_t skipped;  ///< of these, cut off before the first one kept
  int at;                ///< where the first one kept lands in the square
  int count;             ///< pixels kept
};

/// What of the image fills what of the square; the rest of the square is padding.
struct Window {
  AxisSpan x, y;
};

/// The window of `box`, which lies inside the image.
///
/// kSquash             the box is stretched to the whole square.
/// kLetterbox          the longer side fills the square, the shorter one becomes
///                     max(1, round(shorter * size / longer)) pixels, centred; of an odd rest the larger half
///                     is right or below.
/// kSquareContext      a square of side max(w, h) around the box's centre (rounded down), moved as little as
///                     needed to lie inside the image or, along an axis where the image is smaller, to cover
///                     it. The part of it inside the image, at least one pixel, is stretched to where it lies
///                     in the square, rounded to whole pixels.
/// kShorterSideCentre  torchvision's Resize(round(size / crop_fraction)): the shorter side to that, the
///                     longer to floor(that * longer / shorter). Then its CenterCrop(size), at
///                     round((side - size) / 2). What it cuts off is never computed. Halves are rounded to
///                     even, as Python does.
Window window_of(const Box& box, const Image& image, const CropOptions& options);

}  // namespace edgefusion
