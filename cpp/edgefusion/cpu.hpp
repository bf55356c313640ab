// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

namespace edgefusion {

/// Whether this machine runs AVX2 code. ARMv8-A needs no such question: NEON is part of it.
inline bool cpu_has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

}  // namespace edgefusion
