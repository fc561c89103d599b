// Student's t distribution, computed, for any (also fractional) degrees of freedom.
#pragma once

namespace ohb::renderer {

/// Regularised incomplete beta function I_x(a, b), a and b > 0, x in [0, 1]; relative error below 1e-10.
/// Continued fraction of Abramowitz and Stegun 26.5.8, by the modified Lentz method.
double incomplete_beta(double a, double b, double x);

/// Probability that |T| >= |t| with `dof` > 0 degrees of freedom (A&S 26.7.1), accurate far into the tail.
double student_two_sided_p(double t, double dof);

/// The t >= 0 whose two-sided probability is p in (0, 1].
double student_two_sided_quantile(double p, double dof);

/// The z >= 0 whose two-sided probability under the standard normal is p in (0, 1]; at most 38.
double normal_two_sided_quantile(double p);

}  // namespace ohb::renderer
