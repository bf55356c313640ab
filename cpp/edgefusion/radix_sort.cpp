// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/radix_sort.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace edgefusion {
namespace {

// 2048 buckets and the lines being written to them still fit a first-level cache.
constexpr int kMaxDigitBits = 11;
constexpr int kMinDigitBits = 6;

// About a bucket per record: a scan of 361 beams must not pay for 2048 of them.
int widest_digit(std::size_t n) {
  int bits = kMinDigitBits;
  while (bits < kMaxDigitBits && (n >> bits) > 0) ++bits;
  return bits;
}

// A stable pass of the counting sort over one digit.
void sort_by_digit(const std::vector<Keyed>& from, std::vector<Keyed>& to, int shift, int digit_bits) {
  std::array<std::uint32_t, std::size_t{1} << kMaxDigitBits> next;
  const std::uint64_t mask = (std::uint64_t{1} << digit_bits) - 1;
  std::fill_n(next.begin(), mask + 1, 0U);
  for (const Keyed& record : from) ++next[(record.key >> shift) & mask];
  std::uint32_t sum = 0;
  for (std::size_t digit = 0; digit <= mask; ++digit) {
    const std::uint32_t count = next[digit];
    next[digit] = sum;
    sum += count;
  }
  for (const Keyed& record : from) to[next[(record.key >> shift) & mask]++] = record;
}

}  // namespace

void radix_sort(std::vector<Keyed>& records, int bits) {
  if (bits == 0) return;
  const int widest = widest_digit(records.size());
  const int passes = (bits + widest - 1) / widest;
  const int digit_bits = (bits + passes - 1) / passes;
  std::vector<Keyed> other(records.size());
  for (int pass = 0; pass < passes; ++pass) {
    sort_by_digit(records, other, pass * digit_bits, digit_bits);
    records.swap(other);
  }
}

}  // namespace edgefusion
