// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <vector>

namespace edgefusion {

/// c[0] + c[1] x + c[2] x^2 + ...
using Polynomial = std::vector<double>;

double evaluate(const Polynomial& p, double x);
Polynomial derivative(const Polynomial& p);
Polynomial add(const Polynomial& a, const Polynomial& b);
Polynomial scale(Polynomial p, double factor);
Polynomial multiply(const Polynomial& a, const Polynomial& b);

/// Where the polynomial changes its sign for x > 0, rising; where it only touches zero may count as well.
std::vector<double> positive_sign_changes(const Polynomial& p);

}  // namespace edgefusion
