// The stress catalogue at small sizes, without Cycles and without what takes gigabytes.
#include "dataset/studies/stress.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "dataset/studies/stress_scenes.h"
#include "tests/support/paths.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace renderer;
using namespace studies;
namespace {

std::vector<StressCase> catalogue() {
  return read_stress_catalogue(source_path("assets/stress/catalogue.json"));
}

TEST(Stress, EveryCaseIsWithinItsLimits) {
  StressSettings settings;
  settings.with_cycles = settings.with_heavy = false;
  settings.size_px = 16;
  settings.spp = 64;
  std::vector<StressCase> cases = catalogue();
  for (StressCase& stress : cases)
    for (StressPoint& point : stress.points) point.accept.slowdown = -1;  // times are for an idle machine
  ASSERT_GE(cases.size(), 14u);
  const TemporaryFolder scratch;
  for (const StressCaseResult& result : run_stress(cases, settings, scratch.path())) {
    EXPECT_FALSE(result.results.empty());
    for (const StressResult& r : result.results)
      for (const std::string& failure : r.failures)
        ADD_FAILURE() << result.stress.name << " at " << r.point.at << ": " << failure;
  }
}

TEST(Stress, LeaksAreCounted) {
  StressSettings settings;
  settings.with_cycles = false;
  settings.size_px = 16;
  settings.spp = 16;
  std::vector<StressCase> cases = catalogue();
  for (StressCase& stress : cases)
    if (stress.scene == "open ball")
      for (StressPoint& point : stress.points) point.accept.leaks = 1e-5;
  const TemporaryFolder scratch;
  settings.only = "open ball of skin";
  const StressCaseResult open = run_stress(cases, settings, scratch.path()).at(0);
  EXPECT_EQ(open.results.front().leaks, 0) << "a closed ball";
  EXPECT_GT(open.results.back().leaks, 0.01) << "a bowl";
  EXPECT_FALSE(open.passes());
}

TEST(Stress, NonFiniteContributionsAreCountedNotHidden) {
  StressSettings settings;
  settings.with_cycles = false;
  settings.size_px = 16;
  settings.spp = 16;
  settings.only = "NaN texels";
  const TemporaryFolder scratch;
  const StressCaseResult nan = run_stress(catalogue(), settings, scratch.path()).at(0);
  EXPECT_EQ(nan.results.front().nonfinite_share, 0);
  EXPECT_GT(nan.results[2].nonfinite_share, 0) << "1 % of NaN";
  for (const StressResult& r : nan.results) EXPECT_EQ(r.nan_pixels, 0u);
}

TEST(Stress, BadCataloguesAreRefused) {
  const TemporaryFolder folder;
  const auto message_of = [&](const std::string& text) {
    return input_error_of([&] { read_stress_catalogue(write_bytes(folder / "c.json", text)); });
  };
  expect_message(message_of("{"), {"c.json", "well-formed"});
  expect_message(message_of(R"({"cases": [{"name": "x"}]})"), {"c.json", "case 1 (x)", "scene"});
  const std::string head =
      R"({"cases": [{"name": "x", "scene": "sun", "what": "", "parameter": "", "acceptable": "", )";
  expect_message(message_of(head + R"("accept": {"beauty": 1}, "points": [1]}]})"), {"case 1 (x)", "beauty"});
  expect_message(message_of(head + R"("accept": {}, "points": []}]})"), {"case 1 (x)", "points"});
  expect_message(input_error_of([] { stress_scene("swamp", 1); }), {"swamp", "roughness"});
}

}  // namespace
}  // namespace ohb
