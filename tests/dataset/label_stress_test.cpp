// A short version of the label's stress cases, on a person of one tube.
#include <gtest/gtest.h>

#include "dataset/commands/label_report.h"
#include "tests/bench/robot_stress.h"
#include "tests/support/paths.h"
#include "tests/support/tube_person.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

TEST(LabelStress, CasesAreWithinTheirLimitsAndTheLimitsBite) {
  TubePerson person;
  make_tube_person(24, 80, person);
  for (size_t f = 0; f < person.truth.size(); ++f) {  // blue trousers of leather: strokes must say so
    const float y = person.scan.positions[person.scan.corners[person.scan.face_begin[f]].position].y;
    if (y < 85) person.truth[f] = kLeather;
  }
  const RobotHuman human{"tube", person.scan, person.truth, face_areas(person.scan), {}};
  std::vector<RobotStressCase> cases = read_robot_stress(source_path("assets/stress/label_catalogue.json"));
  ASSERT_EQ(cases.size(), 3u);
  cases[2].points.resize(2);  // the tube's picture is 256 px wide
  for (const RobotStressResult& r : run_robot_stress(cases, {human}, 8))
    EXPECT_TRUE(r.failure.empty()) << r.stress.name << " at " << r.point.at << ": " << r.failure;
  std::vector<RobotStressCase> impossible = {cases[0]};
  impossible[0].points = {{1, 0.999, 0.999, "every stroke is wrong"}};
  EXPECT_FALSE(run_robot_stress(impossible, {human}, 8).at(0).failure.empty());
}

TEST(LabelStress, BadCataloguesAreRefused) {
  const TemporaryFolder folder;
  const auto message_of = [&](const std::string& text) {
    return input_error_of([&] { read_robot_stress(write_bytes(folder / "c.json", text)); });
  };
  expect_message(message_of("["), {"c.json", "parse"});
  expect_message(message_of(R"({"cases": [{"name": "x", "damage": "fire"}]})"), {"case 1", "fire"});
}

}  // namespace
}  // namespace ohb
