// Against closed forms and tabulated quantiles (Abramowitz and Stegun, table 26.10).
#include "renderer/student_t.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ohb {
using namespace renderer;
namespace {

TEST(StudentT, ClosedForms) {
  for (const double t : {0.0, 0.3, 1.0, 5.0, 40.0, 1e4}) {
    EXPECT_NEAR(student_two_sided_p(t, 1), 1 - 2 / M_PI * std::atan(t), 1e-12) << t;
    const double two = 1 - t / std::sqrt(2 + t * t);
    EXPECT_NEAR(student_two_sided_p(-t, 2), two, 1e-12) << t;
  }
  // Far tail of dof 2: 1 / t^2 to first order.
  EXPECT_NEAR(student_two_sided_p(1e6, 2) * 1e12, 1.0, 1e-6);
}

TEST(StudentT, QuantilesOfTables) {
  EXPECT_NEAR(student_two_sided_quantile(0.05, 14), 2.145, 5e-4);
  EXPECT_NEAR(student_two_sided_quantile(0.01, 7), 3.499, 5e-4);
  EXPECT_NEAR(student_two_sided_quantile(0.001, 10), 4.587, 5e-4);
  EXPECT_NEAR(student_two_sided_quantile(0.05, 1e7), 1.959964, 1e-5);
  EXPECT_NEAR(student_two_sided_quantile(1.0, 5), 0.0, 1e-9);
}

TEST(StudentT, QuantileInvertsProbability) {
  for (const double dof : {1.0, 3.7, 7.0, 14.0, 100.0})
    for (const double p : {0.9, 0.05, 1e-4, 1e-9})
      EXPECT_NEAR(student_two_sided_p(student_two_sided_quantile(p, dof), dof) / p, 1, 1e-8)
          << dof << " " << p;
}

TEST(StudentT, NormalQuantile) {
  EXPECT_NEAR(normal_two_sided_quantile(0.05), 1.959964, 1e-6);
  EXPECT_NEAR(normal_two_sided_quantile(1.0), 0, 1e-9);
  EXPECT_GT(normal_two_sided_quantile(0), 30);
}

}  // namespace
}  // namespace ohb
