// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include "edgefusion/crops.hpp"

using namespace edgefusion;
