// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include <doctest/doctest.h>

#include "edgefusion/boxes.hpp"

using namespace edgefusion;
