// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace edgefusion {

/// A number as short as tells it from all others: 0.1, not 0.100000; 1.0000001, not 1.
template <typename Float>
std::string shown(Float value) {
  if (std::isnan(value)) return "nan";
  std::string text;
  for (int digits = 6; digits <= std::numeric_limits<Float>::max_digits10; ++digits) {
    std::stringstream stream;
    stream.imbue(std::locale::classic());
    stream.precision(digits);
    stream << value;
    text = stream.str();
    Float read = 0;
    if (stream >> read && read == value) break;
  }
  return text;
}

/// Throws std::invalid_argument of one line: "name: expected ..., got ...", put together from its parts.
template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  const auto text_of = [](const auto& part) {
    if constexpr (std::is_floating_point_v<std::decay_t<decltype(part)>>) {
      return shown(part);
    } else if constexpr (std::is_arithmetic_v<std::decay_t<decltype(part)>>) {
      return std::to_string(part);
    } else {
      return std::string(part);
    }
  };
  throw std::invalid_argument((text_of(parts) + ...));
}

/// Refuses a value that is not finite, by its index.
inline void expect_finite(const char* name, const double* values, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    if (!std::isfinite(values[i]))
      refuse(name, ": expected finite numbers, got ", values[i], " at index ", i);
}

}  // namespace edgefusion
