// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include "edgefusion/ball.hpp"
#include "edgefusion/points.hpp"

namespace edgefusion {

/// Whether some point of `a` reaches some point of `b`. Near-linear in their sizes.
bool touch(const Points& points, const Ball& ball, PointRange a, PointRange b);

}  // namespace edgefusion
