// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include "edgefusion/row_kernels.hpp"

namespace edgefusion {

#if defined(__aarch64__)
/// For every ARMv8-A machine.
extern const RowKernels kNeonKernels;
#endif

}  // namespace edgefusion
