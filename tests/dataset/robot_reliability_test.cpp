// The reliability diagram of label_robot: what a bin holds, and how much so many garments show.
#include <gtest/gtest.h>

#include "tests/bench/robot_reliability.h"

namespace ohb {
namespace {

/// `people` of one garment each, all of one claim; the first `wrong` are wrong. Each in `forms` scans.
std::vector<PersonClaims> claims_of(int people, int wrong, int forms) {
  std::vector<PersonClaims> all;
  for (int p = 0; p < people; ++p)
    for (int form = 0; form < forms; ++form)
      all.push_back({std::to_string(p), {{0.85f, 1, p < wrong ? 0.0 : 1.0, 0}}});
  return all;
}

TEST(RobotReliability, ABinShowsNoMoreThanItsGarments) {
  const auto bin_of = [](const std::vector<PersonClaims>& people) {
    return bins_of_equal_width(people).at(8);
  };
  const ReliabilityBin ten = bin_of(claims_of(10, 0, 1)), twice = bin_of(claims_of(10, 0, 2));
  EXPECT_NEAR(ten.garments, 10, 1e-9);
  EXPECT_NEAR(twice.garments, 10, 1e-9) << "forms of one garment are right or wrong together";
  EXPECT_NEAR(ten.low, 10 / (10 + 1.645 * 1.645), 1e-9);
  EXPECT_NEAR(ten.high, 1, 1e-9);
  // Wilson's interval of 8 of 10 at 90 %, by hand: (0.8 + 0.1353) / 1.2706 -+ 0.1953
  const ReliabilityBin eight = bin_of(claims_of(10, 2, 1));
  EXPECT_NEAR(eight.low, 0.541, 2e-3);
  EXPECT_NEAR(eight.high, 0.931, 2e-3);
  EXPECT_NEAR(eight.error(), 0.05, 1e-6);
  EXPECT_GT(bin_of(claims_of(100, 20, 1)).low, eight.low);
}

}  // namespace
}  // namespace ohb
