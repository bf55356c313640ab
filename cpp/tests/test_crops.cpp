// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "edgefusion/cropper.hpp"
#include "edgefusion/crops.hpp"
#include "edgefusion/row_kernels.hpp"
#include "edgefusion/window.hpp"

using namespace edgefusion;

namespace {

struct Pixels {
  int height, width;
  std::vector<std::uint8_t> bytes;

  // Exactly as large as its pixels, so that the address sanitizer sees a read behind them.
  Pixels(int h, int w) : height(h), width(w), bytes(static_cast<std::size_t>(3 * h * w)) {
    std::mt19937 random(static_cast<unsigned>(h * 31 + w));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  }
  Image image() const { return {bytes.data(), height, width, 3 * width, 3, 1}; }
};

CropOptions options_of(int size, Fit fit = Fit::kSquash, Filter filter = Filter::kAntialias,
                       double fraction = 1) {
  return {size, {0, 0, 0}, {1, 1, 1}, fit, filter, fraction};
}

std::vector<float> crop(const Image& image, const Box& box, const CropOptions& options,
                        const RowKernels& kernels = best_kernels()) {
  std::vector<float> out(static_cast<std::size_t>(3 * options.size * options.size), -1);
  Cropper(image, options, kernels).crop(box, out.data());
  return out;
}

double triangle(double distance, double support) {
  return std::max(0.0, 1 - std::abs(distance) / support);
}

// One channel of one output pixel from its definition, in double, over every pixel of the box.
double by_definition(const Image& image, const Box& box, int size, Filter filter, int x, int y, int channel) {
  const bool antialias = filter == Filter::kAntialias;
  const double sx = double(box.width()) / size, sy = double(box.height()) / size;
  const double rx = antialias ? std::max(1.0, sx) : 1, ry = antialias ? std::max(1.0, sy) : 1;
  double cx = (x + 0.5) * sx - 0.5, cy = (y + 0.5) * sy - 0.5;
  if (!antialias) cx = std::clamp(cx, 0.0, box.width() - 1.0), cy = std::clamp(cy, 0.0, box.height() - 1.0);
  double sum = 0, weights = 0;
  for (int j = 0; j < box.height(); ++j)
    for (int i = 0; i < box.width(); ++i) {
      const double weight = triangle(i - cx, rx) * triangle(j - cy, ry);
      weights += weight;
      sum += weight * image.data[(box.y0 + j) * image.row_stride + (box.x0 + i) * image.pixel_stride +
                                 channel * image.channel_stride];
    }
  return sum / weights;
}

std::string message_of(const Image& image, const Box& box, const CropOptions& options) {
  std::vector<float> out(static_cast<std::size_t>(6 * std::max(1, options.size) * std::max(1, options.size)));
  const Box boxes[] = {{0, 0, 1, 1}, box};
  try {
    crops(image, boxes, 2, options, out.data());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

const Filter kFilters[] = {Filter::kAntialias, Filter::kLinear};

}  // namespace

TEST_CASE("every pixel is what the filter's definition says, to 1/30 of a grey level, on both paths") {
  const Pixels pixels(61, 83);
  const Image image = pixels.image();
  const Box boxes[] = {{0, 0, 83, 61},   {3, 5, 20, 60},  {70, 0, 83, 9},
                       {82, 60, 83, 61}, {0, 10, 83, 11}, {9, 0, 10, 61}};
  for (const RowKernels* kernels : {&kGenericKernels, &best_kernels()})
    for (const Box& box : boxes)
      for (const Filter filter : kFilters)
        for (const int size : {1, 2, 7, 16, 33, 90}) {
          const auto out = crop(image, box, options_of(size, Fit::kSquash, filter), *kernels);
          double worst = 0;
          for (int c = 0; c < 3; ++c)
            for (int y = 0; y < size; y += 1 + size / 9)
              for (int x = 0; x < size; x += 1 + size / 9) {
                const double expected = by_definition(image, box, size, filter, x, y, 2 - c);
                worst = std::max(worst, std::abs(255 * double(out[(c * size + y) * size + x]) - expected));
              }
          CHECK(worst < 1 / 30.);
        }
}

#if defined(__aarch64__)
TEST_CASE("ARMv8-A always gets vector code") {
  CHECK(&best_kernels() != &kGenericKernels);
}
#endif

TEST_CASE("the vector code gives the generic code's bits") {
  std::mt19937 random(5);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int round = 0; round < 300; ++round) {
    const Pixels pixels(1 + below(90), 1 + below(200));
    const int x0 = below(pixels.width), y0 = below(pixels.height);
    const Box box{x0, y0, x0 + 1 + below(pixels.width - x0), y0 + 1 + below(pixels.height - y0)};
    const auto fit = static_cast<Fit>(round % 4);
    const auto options = options_of(1 + below(100), fit, kFilters[below(2)], 0.875);
    CHECK(crop(pixels.image(), box, options) == crop(pixels.image(), box, options, kGenericKernels));
  }
}

TEST_CASE("a box as large as the square keeps its pixels, whatever the strides") {
  const Pixels pixels(40, 50);
  const Image plain = pixels.image();
  const Image turned{plain.data + 39 * plain.row_stride + 49 * 3 + 2, 20, 25, -2 * plain.row_stride, -6, -1};
  for (const Image& image : {plain, turned})
    for (const Filter filter : kFilters) {
      const auto out = crop(image, {4, 1, 20, 17}, options_of(16, Fit::kSquash, filter));
      bool same = true;
      for (int i = 0; i < 3 * 16 * 16; ++i) {
        const int c = i / 256, y = i / 16 % 16, x = i % 16;
        const auto pixel = image.data[(1 + y) * image.row_stride + (4 + x) * image.pixel_stride +
                                      (2 - c) * image.channel_stride];
        same = same && std::lround(255 * out[i]) == pixel && std::abs(255 * out[i] - pixel) < 1e-4f;
      }
      CHECK(same);
    }
}

TEST_CASE("a flat box stays flat, however long and thin") {
  std::vector<std::uint8_t> bytes(3 * 5000, 200);
  const Image wide{bytes.data(), 1, 5000, 15000, 3, 1}, tall{bytes.data(), 5000, 1, 3, 3, 1};
  for (const Filter filter : kFilters)
    for (const Fit fit : {Fit::kSquash, Fit::kShorterSideCentre})
      for (const int size : {1, 3, 224, 512})
        for (const bool lying : {true, false}) {
          const Box box = lying ? Box{0, 0, 5000, 1} : Box{0, 0, 1, 5000};
          const auto out = crop(lying ? wide : tall, box, options_of(size, fit, filter));
          const auto ends = std::minmax_element(out.begin(), out.end());
          CHECK(*ends.first == doctest::Approx(200 / 255.).epsilon(1e-6));
          CHECK(*ends.second == doctest::Approx(200 / 255.).epsilon(1e-6));
        }
}

TEST_CASE("pixels outside the box never count") {
  Pixels pixels(30, 40);
  const Box box{10, 8, 25, 20};
  const auto before = crop(pixels.image(), box, options_of(21));
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      if (x < box.x0 || x >= box.x1 || y < box.y0 || y >= box.y1)
        std::fill_n(&pixels.bytes[static_cast<std::size_t>(3 * (40 * y + x))], 3, std::uint8_t{255});
  CHECK(crop(pixels.image(), box, options_of(21)) == before);
}

TEST_CASE("a box that is empty or leaves the image is refused by its index, values and the image's size") {
  const Pixels pixels(30, 40);
  const Image image = pixels.image();
  const auto options = options_of(4);
  CHECK(message_of(image, {5, 2, 5, 9}, options) == "boxes[1]: (5, 2, 5, 9) is empty; image 40 x 30");
  CHECK(message_of(image, {5, 9, 6, 2}, options) == "boxes[1]: (5, 9, 6, 2) is empty; image 40 x 30");
  CHECK(message_of(image, {5, 2, 41, 9}, options) ==
        "boxes[1]: (5, 2, 41, 9) is not inside the image; image 40 x 30");
  for (const Box& box :
       {Box{-1, 0, 2, 2}, Box{0, -1, 2, 2}, Box{0, 0, 2, 31}, Box{INT32_MIN, 0, INT32_MAX, 1}})
    CHECK(message_of(image, box, options).find("not inside") != std::string::npos);
}

TEST_CASE("options without meaning are refused by name") {
  const Pixels pixels(3, 3);
  const Image image = pixels.image();
  const auto refusal = [&](int size, float mean, float std, double fraction) {
    return message_of(image, {0, 0, 1, 1},
                      {size, {0, mean, 0}, {1, 1, std}, Fit::kSquash, Filter::kLinear, fraction});
  };
  CHECK(refusal(1, 0, 1, 1) == "");
  CHECK(refusal(0, 0, 1, 1).find("size") == 0);
  for (const float std : {0.0f, -1.0f, NAN, INFINITY}) CHECK(refusal(1, 0, std, 1).find("std") == 0);
  for (const float mean : {NAN, -INFINITY}) CHECK(refusal(1, mean, 1, 1).find("mean") == 0);
  CHECK(refusal(1, 0, 1, 1.0000001) == "crop_fraction: expected above 0 and at most 1, got 1.0000001");
  for (const double fraction : {0.0, -1.0, 1.1, double(NAN), 1e-300})
    CHECK(refusal(1, 0, 1, fraction).find("crop_fraction") == 0);
}

TEST_CASE("an image whose rows have more bytes than an int counts is refused") {
  const std::uint8_t pixel[3] = {};
  const Image wide{pixel, 1, kMaxImageSide + 1, 0, 0, 1}, high{pixel, kMaxImageSide + 1, 1, 0, 0, 1};
  for (const Image& image : {wide, high})
    CHECK(message_of(image, {0, 0, 1, 1}, options_of(1)).find("image: expected at most 268435456 pixels") ==
          0);
}

namespace {

std::vector<int> spans(const Box& box, int width, int height, const CropOptions& options) {
  const Window window = window_of(box, {nullptr, height, width, 0, 0, 0}, options);
  return {window.x.source, window.x.length, window.x.at, window.x.count,
          window.y.source, window.y.length, window.y.at, window.y.count};
}

}  // namespace

TEST_CASE("a letterbox keeps the shape, centred, the larger rest behind") {
  const auto options = options_of(10, Fit::kLetterbox);
  CHECK(spans({5, 6, 25, 16}, 99, 99, options) == std::vector<int>{5, 20, 0, 10, 6, 10, 2, 5});
  CHECK(spans({5, 6, 6, 99}, 99, 99, options) == std::vector<int>{5, 1, 4, 1, 6, 93, 0, 10});
}

TEST_CASE("square context moves inside the image where it fits and is padded where it cannot") {
  const auto options = options_of(10, Fit::kSquareContext);
  CHECK(spans({40, 40, 60, 50}, 99, 99, options) == std::vector<int>{40, 20, 0, 10, 35, 20, 0, 10});
  CHECK(spans({40, 0, 60, 10}, 99, 99, options) == std::vector<int>{40, 20, 0, 10, 0, 20, 0, 10});
  CHECK(spans({40, 90, 60, 99}, 99, 99, options) == std::vector<int>{40, 20, 0, 10, 79, 20, 0, 10});
  // 80 wide in an image 40 high: rows -20..60 would centre it on the box, so half of the square is padding,
  // 3 + 2 rows of 10.
  CHECK(spans({10, 15, 90, 25}, 99, 40, options) == std::vector<int>{10, 80, 0, 10, 0, 40, 3, 5});
  CHECK(spans({0, 0, 5000, 1}, 5000, 1, options_of(2, Fit::kSquareContext)) ==
        std::vector<int>{0, 5000, 0, 2, 0, 1, 1, 1});
}

TEST_CASE("shorter side and centre follow torchvision's rounding") {
  const auto window = [](int width, int height, int size, double fraction) {
    return window_of({0, 0, width, height}, {nullptr, height, width, 0, 0, 0},
                     options_of(size, Fit::kShorterSideCentre, Filter::kAntialias, fraction));
  };
  const Window vga = window(640, 480, 224, 0.875);
  CHECK(vga.x.resized == 341);  // int(256 * 640 / 480)
  CHECK(vga.y.resized == 256);
  CHECK(vga.x.skipped == 58);  // round(58.5)
  CHECK(vga.y.skipped == 16);
  CHECK(window(9, 9, 126, 224 / 232.).x.resized == 130);  // round(130.5)
  CHECK(window(3, 6, 7, 1).y.skipped == 4);               // round(3.5)
  CHECK(window(5, 7, 15, 1).y.skipped == 3);              // 21 - 15
}
