// label and bake from files to folders: results and warnings.
#include "dataset/commands/bake_scan.h"
#include "dataset/commands/label.h"
#include "dataset/model/data_files.h"
#include "tests/dataset/labelled_square.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"
#include "tests/support/tube_person.h"

namespace ohb {
using namespace bake;
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

namespace fs = std::filesystem;

TEST(LabelBake, DelightReportsAndLeavesNothingBehind) {
  Square square;
  label_scan(square.label);
  square.bake.delights = true;
  const BakeScanReport report = bake_scan(square.bake);
  ASSERT_EQ(report.delight.regions.size(), 2u);
  EXPECT_EQ(report.delight.regions[0].name, "skin");
  EXPECT_FALSE(report.delight.regions[0].is_delit) << "an open square has no shade";
  EXPECT_EQ(report.delight.regions[0].mean_irradiance, 1);
  EXPECT_NE(to_text(report).find("nothing to delight"), std::string::npos);
  EXPECT_NE(read_file(square.bake.output / "report.json").find("\"least_slope\""), std::string::npos);
  EXPECT_TRUE(fs::is_regular_file(square.bake.output / "maps/shirt/divisor.png"));
  EXPECT_FALSE(fs::exists(square.bake.output / "delit"));
  read_model(square.bake.output);
  square.bake.source = square.bake.scan;
  expect_message(input_error_of([&] { bake_scan(square.bake); }), {"--delight", "source"});
}

TEST(LabelBake, FromFilesToAModelThatReadsBack) {
  Square square;
  square.label.truth = write_bytes(square.folder / "truth.txt", "0\n3\n");
  const LabelReport report = label_scan(square.label);
  EXPECT_DOUBLE_EQ(report.truth->accuracy, 0.5);
  EXPECT_DOUBLE_EQ(*report.truth->iou[kSkin], 1);
  EXPECT_DOUBLE_EQ(*report.truth->iou[kFabric], 0);
  EXPECT_FALSE(report.truth->iou[kHair].has_value());
  EXPECT_DOUBLE_EQ(report.truth->confusion[kLeather][kFabric], 0.5);
  EXPECT_EQ(*report.unit_cm, 1);
  const Image classes = read_image(square.folder / "regions/maps/shirt/classes.png");
  EXPECT_EQ(classes.width_px, 8);
  EXPECT_EQ(std::lround(*classes.pixel(6, 6) * 255), kSkin);
  EXPECT_EQ(std::lround(*classes.pixel(1, 1) * 255), kFabric);

  bake_scan(square.bake);
  const Model model = read_model(square.bake.output);
  EXPECT_EQ(model.name, "square");
  EXPECT_EQ(model.triangles[1].material_class, kFabric);
  EXPECT_NEAR(*model.sets[0].roughness.pixel(6, 6), 0.4f, 1e-3f);
  EXPECT_EQ(model.sets[0].normal.pixel(3, 3)[2], 1.0f);
  EXPECT_EQ(model.source_sha256, sha256_of_file(square.bake.scan));
  EXPECT_TRUE(fs::exists(square.bake.output / "report.json"));
}

TEST(LabelBake, UnitsAreAppliedAndRecorded) {
  Square square;
  square.bake.unit = "inch";
  label_scan(square.label);
  EXPECT_EQ(bake_scan(square.bake).bake.unit_cm, 2.54);
  EXPECT_NEAR(bounds_of(read_model(square.bake.output).positions_cm).high.y, 381, 1e-3);
}

TEST(LabelBake, OrderOfClassesComesFromTheJsonBesideTheFile) {
  Square square;
  square.label.faces = write_bytes(square.folder / "square.labels.txt", "0\n1\n");
  write_bytes(square.folder / "square.json", R"({"classes": ["leather", "hair"]})");
  LabelReport report = label_scan(square.label);
  EXPECT_EQ(report.classes[kLeather].faces, 1u);
  EXPECT_EQ(report.classes[kHair].faces, 1u);
  square.label.classes = {"fabric", "skin"};  // the option goes before the file
  report = label_scan(square.label);
  EXPECT_EQ(report.classes[kFabric].faces, 1u);
}

TEST(LabelBake, IdleRulesAreWarnedOf) {
  Square square;
  square.label.faces.clear();
  square.label.rules =
      write_bytes(square.folder / "rules.xml",
                  "<rules default='fabric'><rule class='hair' material='wig'/>"
                  "<rule class='skin' material='shirt'/><rule class='fabric' name='*'/></rules>");
  const LabelReport report = label_scan(square.label);
  ASSERT_EQ(report.warnings.size(), 2u);
  expect_message(report.warnings[0], {"rule 1 (class=\"hair\" material=\"wig\")", "matches none"});
  expect_message(report.warnings[1], {"rule 2", "later rules take all 2"});
}

TEST(LabelBake, WhereNamesSayNothingTheClassesAreInferredAndThatIsSaid) {
  Square square;
  square.label.faces.clear();
  edit(square.folder / "square.obj", "usemtl shirt", "usemtl atlas");
  edit(square.folder / "square.mtl", "newmtl shirt", "newmtl atlas");
  const LabelReport report = label_scan(square.label);
  EXPECT_EQ(report.method, "automatic");
  EXPECT_EQ(report.unlabelled.faces, 0u);
  ASSERT_TRUE(report.inferred);
  EXPECT_EQ(report.inferred->faces, 2u);
  ASSERT_EQ(report.warnings.size(), 2u);
  expect_message(report.warnings[0],
                 {"names do not tell the class of 2 of 2 faces", "inferred", "--strokes"});
  expect_message(report.warnings[1], {"no skin where a face should be", "upright"});
  EXPECT_TRUE(fs::exists(square.folder / "regions/maps/atlas/confidence.png"));
}

TEST(LabelBake, OneNameForAWholePersonSaysNothing) {
  TubePerson person;
  make_tube_person(24, 60, person);
  LabelJob job;
  job.scan = write_tube_obj(person, "body");
  job.output = person.folder / "regions";
  const LabelReport report = label_scan(job);
  EXPECT_EQ(report.method, "automatic");
  ASSERT_EQ(report.warnings.size(), 1u);
  expect_message(report.warnings[0], {"names would make every face skin", "inferred"});
  EXPECT_GT(
      compare_with_truth(read_regions(job.output).face_class, person.truth, face_areas(read_scan(job.scan)))
          .accuracy,
      0.95);
}

TEST(LabelBake, APersonWithoutHairIsSaidToHaveNone) {
  TubePerson person;
  make_tube_person(24, 60, person, true);
  LabelJob job;
  job.scan = write_tube_obj(person, "atlas");
  job.automatic = true;
  job.output = person.folder / "regions";
  const LabelReport report = label_scan(job);
  EXPECT_EQ(report.classes[kHair].faces, 0u);
  ASSERT_EQ(report.warnings.size(), 1u);
  expect_message(report.warnings[0], {"no face became hair", "--strokes"});
}

TEST(LabelBake, NamesThatSaySomethingAreKept) {
  Square square;
  square.label.faces.clear();
  edit(square.folder / "square.obj", "f 1/1 3/3 4/4", "usemtl boot\nf 1/1 3/3 4/4");
  write_bytes(square.folder / "square.mtl", "newmtl shirt\nmap_Kd p.png\nnewmtl boot\nmap_Kd p.png\n");
  EXPECT_EQ(label_scan(square.label).method, "names");
  edit(square.folder / "square.obj", "usemtl shirt", "usemtl atlas");
  edit(square.folder / "square.mtl", "newmtl shirt", "newmtl atlas");
  const LabelReport report = label_scan(square.label);
  EXPECT_EQ(report.method, "names, and automatic where they say nothing");
  EXPECT_EQ(report.inferred->faces, 1u);
  EXPECT_EQ(read_regions(square.folder / "regions").face_class[1], kLeather);
}

TEST(LabelBake, StrokesDecideAndAreKept) {
  Square square;
  square.label.faces.clear();
  square.label.strokes = write_bytes(square.folder / "s.xml",
                                     "<strokes schema='1.0'><stroke class='hair' radius_cm='1' time_s='0'>"
                                     "<point face='0' at='75,30,0'/></stroke></strokes>");
  const LabelReport report = label_scan(square.label);
  EXPECT_EQ(report.method, "strokes");
  EXPECT_EQ(report.inferred->strokes, 1u);
  EXPECT_EQ(read_regions(square.folder / "regions").face_class[0], kHair);
  EXPECT_EQ(read_file(square.folder / "regions/strokes.xml"), read_file(square.label.strokes));
}

}  // namespace
}  // namespace ohb
