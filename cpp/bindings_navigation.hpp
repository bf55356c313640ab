// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <pybind11/pybind11.h>

namespace edgefusion {

/// Adds navigation's classes to the module.
void bind_navigation(pybind11::module_& m);

}  // namespace edgefusion
