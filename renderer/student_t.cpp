#include "renderer/student_t.h"

#include <algorithm>
#include <cmath>

namespace ohb::renderer {
namespace {

constexpr double kTiny = 1e-300;
constexpr int kMaxTerms = 2000;

double not_too_small(double value) {
  return std::fabs(value) < kTiny ? kTiny : value;
}

/// The continued fraction of I_x(a, b) without its leading factor; converges fast for x < (a+1)/(a+b+2).
double beta_fraction(double a, double b, double x) {
  double c = 1, d = 1 / not_too_small(1 - (a + b) * x / (a + 1)), fraction = d;
  for (int m = 1; m <= kMaxTerms; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    for (const double term : {even, odd}) {
      d = 1 / not_too_small(1 + term * d);
      c = not_too_small(1 + term / c);
      fraction *= c * d;
    }
    if (std::fabs(c * d - 1) < 1e-14) break;
  }
  return fraction;
}

/// The x in [0, high] where a falling function reaches p.
template <class Function>
double invert_falling(const Function& function, double p, double high) {
  double low = 0;
  for (int i = 0; i < 200 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (function(middle) > p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double incomplete_beta(double a, double b, double x) {
  if (!(x > 0)) return 0;
  if (!(x < 1)) return 1;
  const double log_factor =
      std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x);
  if (x < (a + 1) / (a + b + 2)) return std::exp(log_factor) * beta_fraction(a, b, x) / a;
  return 1 - std::exp(log_factor) * beta_fraction(b, a, 1 - x) / b;
}

double student_two_sided_p(double t, double dof) {
  if (std::isinf(t)) return 0;
  return incomplete_beta(0.5 * dof, 0.5, dof / (dof + t * t));
}

double student_two_sided_quantile(double p, double dof) {
  double high = 1;
  while (high < 1e100 && student_two_sided_p(high, dof) > p) high *= 2;
  return invert_falling([dof](double t) { return student_two_sided_p(t, dof); }, p, high);
}

double normal_two_sided_quantile(double p) {
  return invert_falling([](double z) { return std::erfc(z / std::sqrt(2.0)); }, std::max(p, 1e-300), 38.0);
}

}  // namespace ohb::renderer
