// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "edgefusion/polynomial.hpp"

#include <algorithm>
#include <cmath>

namespace edgefusion {
namespace {

Polynomial without_leading_zeros(Polynomial p) {
  while (!p.empty() && p.back() == 0.0) p.pop_back();
  return p;
}

// Cauchy's bound: every root is smaller than this.
double root_bound(const Polynomial& p) {
  double largest = 0.0;
  for (const double c : p) largest = std::max(largest, std::abs(c / p.back()));
  return 1.0 + largest;
}

// The sign change of a function that is monotonic between low and high.
double bisect(const Polynomial& p, double low, double high) {
  const bool rises = evaluate(p, high) > 0.0;
  while (true) {
    const double middle = low + 0.5 * (high - low);
    if (middle <= low || middle >= high) return high;
    ((evaluate(p, middle) > 0.0) == rises ? high : low) = middle;
  }
}

}  // namespace

double evaluate(const Polynomial& p, double x) {
  double value = 0.0;
  for (auto c = p.rbegin(); c != p.rend(); ++c) value = value * x + *c;
  return value;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial d;
  for (std::size_t i = 1; i < p.size(); ++i) d.push_back(static_cast<double>(i) * p[i]);
  return d;
}

Polynomial add(const Polynomial& a, const Polynomial& b) {
  Polynomial sum = a;
  sum.resize(std::max(a.size(), b.size()), 0.0);
  for (std::size_t i = 0; i < b.size(); ++i) sum[i] += b[i];
  return sum;
}

Polynomial scale(Polynomial p, double factor) {
  for (double& c : p) c *= factor;
  return p;
}

Polynomial multiply(const Polynomial& a, const Polynomial& b) {
  Polynomial product(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) product[i + j] += a[i] * b[j];
  return product;
}

// Between two turning points (sign changes of the derivative) a polynomial is monotonic, so bisection finds
// what is there; the turning points come from the same function, one degree lower.
std::vector<double> positive_sign_changes(const Polynomial& polynomial) {
  const Polynomial p = without_leading_zeros(polynomial);
  if (p.size() < 2) return {};
  std::vector<double> edges = positive_sign_changes(derivative(p));
  edges.insert(edges.begin(), 0.0);
  edges.push_back(std::max(root_bound(p), 2.0 * edges.back()));

  std::vector<double> changes;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    if ((evaluate(p, edges[i]) > 0.0) != (evaluate(p, edges[i + 1]) > 0.0))
      changes.push_back(bisect(p, edges[i], edges[i + 1]));
  return changes;
}

}  // namespace edgefusion
