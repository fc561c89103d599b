#include "dataset/production/plan.h"

#include <gtest/gtest.h>

#include <set>

#include "dataset/model/error.h"
#include "dataset/production/shard.h"
#include "tests/production/plan_folder.h"
#include "tests/support/paths.h"

namespace ohb::production {
namespace {

namespace fs = std::filesystem;

TEST(Plan, ReadsPeopleLightsAndViews) {
  const PlanFolder folder;
  const Plan plan = read_plan(
      folder.plan(std::string(R"(<people folder="people" split="hash" train="0.5" licence="CC0-1.0"/>)") +
                  kPerson + kEnvironments + kViews +
                  R"(<views split="test" count="1" repeat="4" error="0.1"><point x_cm="1" y_cm="2"
        z_cm="3" intensity="4"/></views>)"));
  ASSERT_EQ(plan.people.size(), 4u);
  EXPECT_EQ(plan.people[0].id, "a");
  EXPECT_EQ(plan.people[1].attributes.at("licence"), "CC0-1.0");
  EXPECT_EQ(plan.views_of(plan.people[0]).set_count(), 3);
  const ViewSet& test = plan.views[1];
  EXPECT_EQ(test.set_count(), 4);
  ASSERT_TRUE(test.goal);
  EXPECT_EQ(test.points[0].position_cm.z, 3);
  for (const PlannedSet& set : sets_of(plan, plan.people[0])) {
    ASSERT_EQ(set.environments.size(), 2u);
    EXPECT_NE(set.environments[0]->name, set.environments[1]->name);
  }
}

TEST(Plan, AnEnvironmentMoreChangesOnlyTheSetsThatDrawIt) {
  const PlanFolder folder;
  const std::string inside =
      kPerson + kEnvironments + R"(<views split="train" count="300"><lights from="e" count="2"/></views>)";
  const auto drawn = [&] {
    const Plan plan = read_plan(folder.plan(inside));
    std::vector<std::string> names;
    for (const PlannedSet& set : sets_of(plan, plan.people[0]))
      names.push_back(std::to_string(set.seed) + set.environments[0]->name + set.environments[1]->name);
    return names;
  };
  const std::vector<std::string> before = drawn();
  folder.write("env/storm.exr", "x");
  const std::vector<std::string> after = drawn();
  size_t changed = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    changed += before[i] != after[i];
    EXPECT_EQ(before[i] != after[i], after[i].find("storm") != std::string::npos) << i;
  }
  // Two of five: expected in 120 of 300, standard deviation 8.5.
  EXPECT_NEAR(static_cast<double>(changed), 120, 40);
}

TEST(Plan, DrawsAreEven) {
  const PlanFolder folder;
  const Plan plan = read_plan(folder.plan(kPerson + kEnvironments +
                                          R"(<views split="train" count="4000"><lights from="e"/></views>)"));
  std::map<std::string, int> count;
  for (const PlannedSet& set : sets_of(plan, plan.people[0])) ++count[set.environments[0]->name];
  for (const auto& [name, times] : count) EXPECT_NEAR(times, 1000, 150) << name;  // 5.5 standard deviations
}

TEST(Plan, AnExactNumberTrains) {
  const PlanFolder folder;
  const Plan plan =
      read_plan(folder.plan(std::string(R"(<people folder="people" split="hash" train_count="2"/>)") +
                            kEnvironments + kViews + R"(<views split="test"><lights from="e"/></views>)"));
  int train = 0;
  for (const PlanPerson& person : plan.people) train += person.split == "train";
  EXPECT_EQ(train, 2);
}

TEST(Plan, AFolderWithTheNameOfThePatternIsRefusedInWords) {
  const PlanFolder folder;
  for (const char* id : {"{id}", "x{id}"}) {
    folder.write(std::string("people/") + id + "/" + id + "_scan.obj", "v 0 0 0\n");
    folder.write(std::string("people/") + id + "/" + id + "_scan.labels.txt", "0\n");
  }
  const fs::path plan =
      folder.plan(std::string(R"(<people folder="people" split="train"/>)") + kEnvironments + kViews);
  EXPECT_THROW(read_plan(plan),
               InputError);  // it names no folder of a dataset; it once took for ever to say so
}

TEST(Plan, EveryPersonIsInOneShard) {
  const PlanFolder folder;
  const Plan plan = read_plan(folder.plan(std::string(R"(<people folder="people" split="train"/>)") +
                                          kPerson + kEnvironments + kViews));
  std::set<std::string> seen;
  for (int i = 1; i <= 3; ++i)
    for (const PlanPerson* person : people_of_shard(plan, {i, 3}))
      EXPECT_TRUE(seen.insert(person->id).second);
  EXPECT_EQ(seen.size(), 4u);
  EXPECT_THROW(parse_shard("0/3"), InputError);
  EXPECT_THROW(parse_shard("4/3"), InputError);
  EXPECT_THROW(parse_shard("1/3x"), InputError);
  EXPECT_THROW(parse_shard("1"), InputError);
}

TEST(Plan, ALibraryOfEnvironmentsIsAFolderOfThem) {
  const PlanFolder folder;
  folder.write("lib/envmaps.xml", "<environments/>");
  folder.write("lib/contact_sheet.exr", "x");
  folder.write("lib/envmaps/storm.exr", "x");
  folder.write("lib/envmaps/calm.exr", "x");
  const Plan plan = read_plan(folder.plan(kPerson + R"(<environments id="e" folder="lib"/>)" + kViews));
  ASSERT_EQ(plan.pools[0].environments.size(), 2u);
  EXPECT_EQ(plan.pools[0].environments[1].name, "storm");
}

TEST(Plan, TheBundledOneIsRead) {
  const Plan plan = read_plan(source_path("assets/plans/small.xml"));
  EXPECT_EQ(plan.people.size(), 1u);
  EXPECT_EQ(plan.set_count(), 4u);
}

struct Refusal {
  const char* name;
  std::string text;   // of the whole file
  const char* words;  // that the one line holds
};

std::string whole(const std::string& inside) {
  return "<plan schema=\"1\" name=\"t\">\n" + inside + "\n</plan>\n";
}

const std::string kRest = kEnvironments + kViews;

std::vector<Refusal> refused_files() {
  return {
      {"Empty", "", "empty"},
      {"NoXml", "hello", "XML"},
      {"CutOff", "<plan schema=\"1\"", "XML"},
      {"OtherRoot", "<scene/>", "root element"},
      {"BillionLaughs",
       "<!DOCTYPE plan [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;&a;\">]>" + whole(kPerson + kRest),
       "document type"},
      {"Deep",
       [] {
         std::string text;
         for (int i = 0; i < 5000; ++i) text += "<plan>";
         return text;
       }(),
       "line 1"},
      {"NewerSchema", "<plan schema=\"2\" name=\"t\"/>", "schema=\"2\""},
      {"NoSchema", "<plan name=\"t\"/>", "schema"},
      {"UnknownAttribute",
       whole("<person id=\"a\" scan=\"a.obj\" labels=\"a.txt\" split=\"train\" hat=\"1\"/>" + kRest),
       "line 2: <person> has an unknown attribute 'hat'"},
      {"UnknownElement", whole(kPerson + kRest + "<camera/>"), "<camera> is not known"},
      {"Text", whole(kPerson + kRest + "hello"), "text inside <plan>"},
      {"TwiceTheAttribute", "<plan schema=\"1\" schema=\"1\" name=\"t\">" + kPerson + kRest + "</plan>",
       "occurs twice"},
      {"MapsLargerThanBakeMakes", whole("<maps size_px=\"8193\"/>" + kPerson + kRest), "size_px=\"8193\""},
      {"TwoRoots", whole(kPerson + kRest) + whole(kPerson + kRest),
       "line 4: not well-formed XML: a second root element, <plan>"},
      {"TextAfterTheRoot", whole(kPerson + kRest) + "hello", "not well-formed XML: text outside of the root"},
      {"OnlyAComment", "<!-- plan -->", "not well-formed XML"},
      {"MaterialsLackAClass",
       whole(kPerson + kRest +
             "<materials specular_encoding=\"srgb-f0\" roughness_encoding=\"perceptual\" "
             "sss_encoding=\"weight-1.0-0.2-0.1-cm\"/>"),
       "no material for class"},
      {"OtherEncoding",
       whole(kPerson + kRest +
             "<materials specular_encoding=\"linear\" roughness_encoding=\"perceptual\" "
             "sss_encoding=\"weight-1.0-0.2-0.1-cm\"/>"),
       "specular_encoding"},
  };
}

std::string with_person(const std::string& attributes) {
  return whole("<person " + attributes + "/>" + kRest);
}

std::vector<Refusal> refused_people() {
  return {
      {"DuplicateId", whole(kPerson + kPerson + kRest), "a second person 'a'"},
      {"DuplicateIdOfOtherCase",
       whole(kPerson + R"(<person id="A" scan="a.obj" labels="a.txt" split="train"/>)" + kRest),
       "a second person 'A'"},
      {"EscapeUp", with_person(R"(id="../../a" scan="a.obj" labels="a.txt" split="train")"),
       "cannot name a folder"},
      {"EscapeAbsolute", with_person(R"(id="/etc" scan="a.obj" labels="a.txt" split="train")"),
       "cannot name a folder"},
      {"HiddenId", with_person(R"(id=".ohb" scan="a.obj" labels="a.txt" split="train")"),
       "cannot name a folder"},
      {"LongId",
       with_person("id=\"" + std::string(65, 'a') + R"(" scan="a.obj" labels="a.txt" split="train")"),
       "cannot name a folder"},
      {"MissingScan", with_person(R"(id="a" scan="gone.obj" labels="a.txt" split="train")"),
       "does not exist"},
      {"ScanIsFolder", with_person(R"(id="a" scan="env" labels="a.txt" split="train")"), "is no file"},
      {"NoLabels", with_person(R"(id="a" scan="a.obj" split="train")"), "neither labels nor regions"},
      {"LabelsAndRegions", with_person(R"(id="a" scan="a.obj" labels="a.txt" regions="env" split="train")"),
       "both labels and regions"},
      {"UnknownSplit", with_person(R"(id="a" scan="a.obj" labels="a.txt" split="training")"),
       "split=\"training\""},
      {"UnknownUnit", with_person(R"(id="a" scan="a.obj" labels="a.txt" split="train" unit="ell")"),
       "unit=\"ell\""},
      {"OldAge", with_person(R"(id="a" scan="a.obj" labels="a.txt" split="train" age="900")"), "age=\"900\""},
      {"Nobody", whole(kRest), "no people"},
      {"EmptyFolder", whole(R"(<people folder="empty" split="train"/>)" + kRest), "holds nobody"},
      {"ShareAboveOne", whole(R"(<people folder="people" split="hash" train="1.5"/>)" + kRest),
       "train=\"1.5\""},
      {"SharesAboveOne", whole(R"(<people folder="people" split="hash" train="0.9" val="0.2"/>)" + kRest),
       "above 1"},
      {"ShareIsNoNumber", whole(R"(<people folder="people" split="hash" train="nan"/>)" + kRest),
       "no number"},
      {"PatternWithoutId", whole(R"(<people folder="people" split="train" scan="scan.obj"/>)" + kRest),
       "{id}"},
      {"PersonWithoutLabels",
       whole(R"(<people folder="people" split="train" labels="{id}/none.txt"/>)" + kRest), "has no"},
  };
}

std::string with_views(const std::string& attributes, const std::string& inside) {
  return whole(kPerson + kEnvironments + "<views split=\"train\" " + attributes + ">" + inside + "</views>");
}

std::vector<Refusal> refused_environments_and_views() {
  const std::string lights = R"(<lights from="e" count="2"/>)";
  return {
      {"NoEnvironments", whole(kPerson + R"(<environments id="e" folder="empty"/>)" + kViews),
       "holds no environment"},
      {"NoSuchFolder", whole(kPerson + R"(<environments id="e" folder="gone"/>)" + kViews), "does not exist"},
      {"OneNameTwice", whole(kPerson + kEnvironments + R"(<environments id="f" folder="more"/>)" + kViews),
       "have one name"},
      {"TwoPoolsOfOneId", whole(kPerson + kEnvironments + kEnvironments + kViews), "a second <environments"},
      {"UnknownPool", with_views("", R"(<lights from="f"/>)"), "is the id of no"},
      {"TooManyLights", with_views("", R"(<lights from="e" count="5"/>)"), "5 different environments"},
      {"TwoDraws", with_views("", lights + lights), "a second draw"},
      {"NoLight", with_views("", ""), "no light"},
      {"NoViews", whole(kPerson + kEnvironments), "which has no views"},
      {"ViewsTwice", whole(kPerson + kRest + kViews), "a second <views"},
      {"ZeroViews", with_views("count=\"0\"", lights), "below 1"},
      {"HugeViews", with_views("count=\"90000\" repeat=\"90000\"", lights), "above 100000"},
      {"SizeIsNegative", with_views("size_px=\"-1\"", lights), "size_px=\"-1\""},
      {"SizeOverflows", with_views("size_px=\"99999999999999999999\"", lights), "size_px"},
      {"SppAndError", with_views("spp=\"4\" error=\"0.1\"", lights), "both spp and error"},
      {"MaxSppAlone", with_views("max_spp=\"64\"", lights), "max_spp"},
      {"UnknownSubsurface", with_views("subsurface=\"deep\"", lights), "subsurface=\"deep\""},
      {"PointFarAway", with_views("", R"(<point x_cm="1e9" y_cm="0" z_cm="0" intensity="1"/>)"),
       "x_cm=\"1e9\""},
      {"PointHoldsMore",
       with_views("", R"(<point x_cm="1" y_cm="0" z_cm="0" intensity="1"><lights/></point>)"),
       "<lights> is not known inside <point>"},
  };
}

class RefusedPlan : public testing::TestWithParam<Refusal> {};

TEST_P(RefusedPlan, InOneLineWithFileAndMend) {
  const PlanFolder folder;
  const fs::path file = folder.write("plan.xml", GetParam().text);
  try {
    read_plan(file);
    FAIL() << "was not refused";
  } catch (const InputError& error) {
    const std::string words = error.what();
    EXPECT_NE(words.find("plan.xml"), std::string::npos) << words;
    EXPECT_NE(words.find(GetParam().words), std::string::npos) << words;
    EXPECT_NE(words.find(';'), std::string::npos) << "no mend: " << words;
    EXPECT_EQ(words.find('\n'), std::string::npos) << words;
  }
}

std::string name_of(const testing::TestParamInfo<Refusal>& parameter) {
  return parameter.param.name;
}
INSTANTIATE_TEST_SUITE_P(File, RefusedPlan, testing::ValuesIn(refused_files()), name_of);
INSTANTIATE_TEST_SUITE_P(People, RefusedPlan, testing::ValuesIn(refused_people()), name_of);
INSTANTIATE_TEST_SUITE_P(Views, RefusedPlan, testing::ValuesIn(refused_environments_and_views()), name_of);

}  // namespace
}  // namespace ohb::production
