// The bake's stress catalogue, and that its limits bite.
#include <gtest/gtest.h>

#include "dataset/studies/bake_stress.h"
#include "dataset/studies/bake_stress_scenes.h"
#include "tests/support/paths.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace studies;
using namespace surface;
namespace {

std::vector<BakeStressCase> catalogue() {
  return read_bake_stress_catalogue(source_path("assets/stress/bake_catalogue.json"));
}

TEST(BakeStressCatalogue, EveryCaseIsWithinItsLimits) {
  const TemporaryFolder scratch;
  const std::vector<BakeStressCase> cases = catalogue();
  ASSERT_GE(cases.size(), 13u);
  for (const BakeStressCaseResult& result : run_bake_stress(cases, "", scratch.path())) {
    EXPECT_FALSE(result.results.empty());
    for (const BakeStressResult& r : result.results)
      for (const std::string& failure : r.failures)
        ADD_FAILURE() << result.stress.name << " at " << r.point.at << ": " << failure;
  }
}

TEST(BakeStressCatalogue, LimitsBite) {
  const TemporaryFolder scratch;
  std::vector<BakeStressCase> cases = catalogue();
  const auto failures_of = [&](const std::string& name, double at, const BakeStressAcceptance& accept) {
    for (BakeStressCase& stress : cases)
      if (stress.name == name) {
        BakeStressPoint point;
        point.at = at;
        point.accept = accept;
        stress.points = {point};
      }
    return run_bake_stress(cases, name, scratch.path()).at(0).results.at(0).failures;
  };
  BakeStressAcceptance accept;
  EXPECT_EQ(failures_of("mirrored UVs", 0.5, accept).size(), 0u);
  accept.normal_deg = accept.colour = accept.depth_cm = 1e-6;
  EXPECT_EQ(failures_of("mirrored UVs", 0.5, accept).size(), 3u);
  accept = {};
  accept.wrong = 0.1;
  accept.warned = "elephants";
  EXPECT_EQ(failures_of("overlapping UVs, allowed", 0.25, accept).size(), 2u);
  accept = {};
  EXPECT_EQ(failures_of("overlapping UVs", 0.25, accept).size(), 1u) << "refused";
  accept.refused = "--max-overlap";
  EXPECT_EQ(failures_of("overlapping UVs", 0.25, accept).size(), 0u);
  EXPECT_EQ(failures_of("overlapping UVs", 0, accept).size(), 1u) << "not refused";
}

TEST(BakeStressCatalogue, BadCataloguesAreRefused) {
  const TemporaryFolder folder;
  const auto message_of = [&](const std::string& text) {
    return input_error_of([&] { read_bake_stress_catalogue(write_bytes(folder / "c.json", text)); });
  };
  expect_message(message_of("{"), {"c.json: line 1", "well-formed"});
  expect_message(message_of(R"({"cases": [{"name": "x"}]})"), {"c.json", "case 1 (x)", "scene"});
  expect_message(
      message_of(
          R"({"cases": [{"name": "x", "scene": "far", "what": "", "parameter": "", "acceptable": "", "accept": {"luck": 1}, "points": [1]}]})"),
      {"case 1 (x)", "luck"});
  BakeStressScene scene;
  expect_message(input_error_of([&] { make_bake_stress_scene("swamp", 1, folder.path(), scene); }),
                 {"swamp", "mirrored"});
}

}  // namespace
}  // namespace ohb
