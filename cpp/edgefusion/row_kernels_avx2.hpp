// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include "edgefusion/row_kernels.hpp"

namespace edgefusion {

#if defined(__x86_64__)
/// Only for a machine that cpu_has_avx2().
extern const RowKernels kAvx2Kernels;
#endif

}  // namespace edgefusion
