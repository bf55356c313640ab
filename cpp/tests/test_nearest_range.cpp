// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include "edgefusion/nearest_range.hpp"

using namespace edgefusion;
