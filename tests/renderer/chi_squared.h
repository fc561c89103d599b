// Chi-squared test of a direction sampler against its pdf, after pbrt and Mitsuba's design.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "dataset/model/sampling.h"

namespace ohb {

/// Upper tail of the chi-squared distribution with k degrees of freedom (Wilson and Hilferty 1931;
/// error below 1e-3 for the k >= 50 used here).
inline double chi_squared_tail(double x, double k) {
  const double z = (std::cbrt(x / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

/// p-value of `observed` counts of `count` draws under the `expected` probabilities; cells with fewer than 5
/// expected draws are pooled.
inline double pooled_chi_squared_p_value(const std::vector<double>& expected,
                                         const std::vector<double>& observed, int count) {
  double statistic = 0, pooled_expected = 0, pooled_observed = 0;
  int cells = 0;
  for (size_t c = 0; c < expected.size(); ++c) {
    const double e = expected[c] * count;
    if (e < 5) {
      pooled_expected += e;
      pooled_observed += observed[c];
      continue;
    }
    statistic += (observed[c] - e) * (observed[c] - e) / e;
    ++cells;
  }
  if (pooled_expected >= 5) {
    statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
    ++cells;
  } else if (pooled_observed > 5 + 5 * std::sqrt(pooled_expected + 1)) {
    return 0;
  }
  return chi_squared_tail(statistic, cells - 1);
}

struct Rectangle {
  double x0, x1, y0, y1;
};

/// Integral of f over a rectangle: midpoints, split in four where a split changes the value.
inline double integrate(const std::function<double(double, double)>& f, const Rectangle& over,
                        double tolerance, int depth) {
  const auto [x0, x1, y0, y1] = over;
  constexpr int kNodes = 3;
  const auto rule = [&](double a0, double a1, double b0, double b1) {
    double sum = 0;
    for (int i = 0; i < kNodes; ++i)
      for (int j = 0; j < kNodes; ++j)
        sum += f(a0 + (a1 - a0) * (i + 0.5) / kNodes, b0 + (b1 - b0) * (j + 0.5) / kNodes);
    return sum * (a1 - a0) * (b1 - b0) / (kNodes * kNodes);
  };
  const double xm = 0.5 * (x0 + x1), ym = 0.5 * (y0 + y1);
  const double whole = rule(x0, x1, y0, y1);
  const double parts =
      rule(x0, xm, y0, ym) + rule(xm, x1, y0, ym) + rule(x0, xm, ym, y1) + rule(xm, x1, ym, y1);
  if (depth == 0 || (std::fabs(whole - parts) < tolerance)) return parts;
  return integrate(f, {x0, xm, y0, ym}, tolerance, depth - 1) +
         integrate(f, {xm, x1, y0, ym}, tolerance, depth - 1) +
         integrate(f, {x0, xm, ym, y1}, tolerance, depth - 1) +
         integrate(f, {xm, x1, ym, y1}, tolerance, depth - 1);
}

/// Draws `count` directions and compares a histogram over (cos theta, phi) with the integral of the pdf.
/// `sample` gives false where it discards a draw; that mass is not part of the pdf's integral.
/// Returns the p-value.
inline double chi_squared_p_value(const std::function<bool(Random&, Vec3f&)>& sample,
                                  const std::function<double(Vec3f)>& pdf, int count, uint64_t seed,
                                  double* integral = nullptr) {
  constexpr int kTheta = 20, kPhi = 40, kDepth = 11;
  std::vector<double> expected(kTheta * kPhi, 0.0), observed(kTheta * kPhi, 0.0);
  const auto direction = [](double z, double phi) {
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return Vec3f{static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                 static_cast<float>(z)};
  };
  double total = 0;
  for (int i = 0; i < kTheta; ++i)
    for (int j = 0; j < kPhi; ++j) {
      expected[i * kPhi + j] = integrate([&](double z, double phi) { return pdf(direction(z, phi)); },
                                         {-1 + 2.0 * i / kTheta, -1 + 2.0 * (i + 1) / kTheta,
                                          2 * M_PI * j / kPhi, 2 * M_PI * (j + 1) / kPhi},
                                         5e-7, kDepth);
      total += expected[i * kPhi + j];
    }
  if (integral) *integral = total;
  Random random(seed, 0, 0);
  for (int n = 0; n < count; ++n) {
    Vec3f wi;
    if (!sample(random, wi)) continue;
    double phi = std::atan2(wi.y, wi.x);
    if (phi < 0) phi += 2 * M_PI;
    const int i = std::min(kTheta - 1, static_cast<int>((wi.z + 1) / 2 * kTheta));
    const int j = std::min(kPhi - 1, static_cast<int>(phi / (2 * M_PI) * kPhi));
    observed[i * kPhi + j] += 1;
  }
  return pooled_chi_squared_p_value(expected, observed, count);
}

}  // namespace ohb
