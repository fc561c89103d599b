// label and bake from files to folders: results, refusals, full disks, kills.
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>

#include "dataset/commands/bake_scan.h"
#include "dataset/commands/label.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
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

/// A person-high square of two triangles with a picture and a normal map, in `folder`.
void write_square(const fs::path& folder) {
  write_bytes(folder / "square.obj",
              "mtllib square.mtl\nusemtl shirt\nv 0 0 0\nv 150 0 0\nv 150 150 0\nv 0 150 0\n"
              "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
  write_bytes(folder / "square.mtl", "newmtl shirt\nmap_Kd p.png\nnorm n.exr\n");
  write_small_png(folder / "p.png");
  Image normal(8, 8, 3);
  for (int i = 0; i < 64; ++i) normal.values[3 * i + 2] = 1;
  write_exr(folder / "n.exr", {{"n", {"R", "G", "B"}, ExrPart::Type::kHalf, normal}}, {});
}

/// Everything that label and bake of the square need.
struct Square {
  TemporaryFolder folder;
  LabelJob label;
  BakeJob bake;
  Square() {
    write_square(folder.path());
    write_bytes(folder / "faces.txt", "0\n2\n");
    write_bytes(folder / "rules.xml", "<rules default='fabric'/>");
    fs::copy_file(program_file("assets/materials.xml"), folder / "materials.xml");
    label.scan = bake.scan = folder / "square.obj";
    label.faces = folder / "faces.txt";
    label.output = bake.regions = folder / "regions";
    bake.materials = folder / "materials.xml";
    bake.output = folder / "model";
    bake.quiet = true;
  }
};

size_t entries_of(const fs::path& folder) {
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

void edit(const fs::path& file, const std::string& from, const std::string& to) {
  std::string content = read_file(file);
  ASSERT_NE(content.find(from), std::string::npos) << file << ": " << from;
  write_bytes(file, content.replace(content.find(from), from.size(), to));
}

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

struct Hostile {
  const char* name;
  std::function<void(Square&)> damage;
  bool is_label;  // label fails; else bake after a good label
  std::vector<std::string> message;
};

std::vector<Hostile> hostile_inputs() {
  const auto faces = [](const std::string& text) {
    return [text](Square& s) { write_bytes(s.folder / "faces.txt", text); };
  };
  const auto materials = [](const std::string& from, const std::string& to) {
    return [from, to](Square& s) { edit(s.folder / "materials.xml", from, to); };
  };
  return {
      {"no scan",
       [](Square& s) { s.label.scan = s.folder / "none.obj"; },
       true,
       {"none.obj", "no such file"}},
      {"label 7", faces("0\n7\n"), true, {"faces.txt: line 2", "\"7\" is no class index", "0 to 3 or 255"}},
      {"label negative", faces("-1\n0\n"), true, {"faces.txt: line 1", "\"-1\" is no class index"}},
      {"label word", faces("0\nskin\n"), true, {"faces.txt: line 2", "\"skin\" is no class index"}},
      {"label fraction", faces("0\n1.5\n"), true, {"faces.txt: line 2", "\"1.5\""}},
      {"blank line", faces("0\n\n1\n"), true, {"faces.txt: line 2", "\"\" is no class index"}},
      {"too few lines", faces("0\n"), true, {"faces.txt", "has 1 lines, the scan has 2 faces"}},
      {"too many lines", faces("0\n1\n2\n"), true, {"faces.txt", "more lines than the scan has faces (2)"}},
      {"empty faces", faces(""), true, {"faces.txt", "has 0 lines"}},
      {"binary faces",
       faces(std::string("\x7f"
                         "ELF\0\1\2",
                         7)),
       true,
       {"faces.txt"}},
      {"no faces file",
       [](Square& s) { s.label.faces = s.folder / "none.txt"; },
       true,
       {"none.txt", "no such file"}},
      {"truth of other length",
       [](Square& s) { s.label.truth = write_bytes(s.folder / "t.txt", "0\n"); },
       true,
       {"t.txt", "has 1 lines"}},
      {"unknown class name",
       [](Square& s) {
         s.label.classes = {"skin", "plastic"};
       },
       true,
       {"'plastic' is not known"}},
      {"broken json",
       [](Square& s) { write_bytes(s.folder / "faces.json", "{"); },
       true,
       {"faces.json", "not well-formed JSON"}},
      {"json classes no list",
       [](Square& s) { write_bytes(s.folder / "faces.json", R"({"classes": 4})"); },
       true,
       {"faces.json: classes", "is not a list of names"}},
      {"rules and faces",
       [](Square& s) { s.label.rules = s.folder / "rules.xml"; },
       true,
       {"--rules", "--faces", "--strokes", "exclude each other"}},
      {"nothing decides",
       [](Square& s) {
         s.label.faces.clear();
         edit(s.folder / "square.obj", "usemtl shirt\n", "");
       },
       true,
       {"names do not tell the class of 2 of 2 faces", "no picture", "--rules", "--strokes"}},
      {"automatic without a picture",
       [](Square& s) {
         s.label.faces.clear();
         s.label.automatic = true;
         edit(s.folder / "square.mtl", "map_Kd p.png\n", "");
       },
       true,
       {"square.obj", "has no picture", "--strokes"}},
      {"automatic without a unit",
       [](Square& s) {
         s.label.faces.clear();
         s.label.automatic = true;
         edit(s.folder / "square.obj", "v 150 150 0\nv 0 150 0", "v 150 50 0\nv 0 50 0");
       },
       true,
       {"square.obj", "unit"}},
      {"strokes of another scan",
       [](Square& s) {
         s.label.faces.clear();
         s.label.strokes = write_bytes(s.folder / "s.xml", "<strokes schema='1.0' scan_sha256='12ab'/>");
       },
       true,
       {"s.xml", "was painted on another scan than square.obj"}},
      {"strokes on a face that does not exist",
       [](Square& s) {
         s.label.faces.clear();
         s.label.strokes = write_bytes(s.folder / "s.xml",
                                       "<strokes schema='1.0'><stroke class='skin' radius_cm='1' time_s='0'>"
                                       "<point face='2' at='0,0,0'/></stroke></strokes>");
       },
       true,
       {"s.xml: stroke 1: face 2 does not exist, the scan has 2"}},
      {"rules leave faces",
       [](Square& s) {
         s.label.faces.clear();
         s.label.rules =
             write_bytes(s.folder / "rules.xml", "<rules><rule class='hair' name='wig'/></rules>");
       },
       true,
       {"rules.xml", "no rule takes 2 of 2 faces (material 'shirt')", "default="}},
      {"unknown unit", [](Square& s) { s.label.unit = "furlong"; }, true, {"--unit", "'furlong' is no unit"}},
      {"output is a file",
       [](Square& s) { s.label.output = s.folder / "p.png"; },
       true,
       {"p.png", "is a file"}},
      {"output is a user's folder",
       [](Square& s) { s.label.output = s.folder.path(); },
       true,
       {"was not written by this program"}},
      {"output below a file",
       [](Square& s) { s.label.output = s.folder / "p.png/regions"; },
       true,
       {"p.png"}},

      {"no regions",
       [](Square& s) { s.bake.regions = s.folder / "none"; },
       false,
       {"none", "no such folder", "label -o"}},
      {"regions without faces",
       [](Square& s) { fs::remove(s.folder / "regions/faces.txt"); },
       false,
       {"faces.txt", "no such file"}},
      {"regions of another scan",
       [](Square& s) { edit(s.folder / "square.obj", "v 0 0 0", "v 0 0 1"); },
       false,
       {"regions", "was made from another scan than square.obj", "run `label`"}},
      {"regions edited",
       [](Square& s) { write_bytes(s.folder / "regions/faces.txt", "0\n9\n"); },
       false,
       {"faces.txt: line 2", "\"9\""}},
      {"regions of a newer version",
       [](Square& s) { edit(s.folder / "regions/regions.xml", "schema=\"1.0\"", "schema=\"2.0\""); },
       false,
       {"regions.xml: line 2", "schema 2.0 is not known"}},
      {"classes in another order",
       [](Square& s) { edit(s.folder / "regions/regions.xml", "name=\"hair\"", "name=\"fabric\""); },
       false,
       {"class 1 is 'fabric', not 'hair'"}},
      {"unlabelled face",
       [](Square& s) { write_bytes(s.folder / "regions/faces.txt", "0\n255\n"); },
       false,
       {"face 1", "has no class (so have 1 of 2 faces)"}},
      {"missing class",
       materials("<material class=\"leather\" specular=\"0.224\" roughness=\"0.250\" sss=\"0.00\"/>", ""),
       false,
       {"materials.xml", "no material for class 'leather'"}},
      {"class twice",
       materials("class=\"leather\"", "class=\"skin\""),
       false,
       {"a second material for class 'skin'"}},
      {"unknown class",
       materials("class=\"leather\"", "class=\"metal\""),
       false,
       {"class=\"metal\" is not known"}},
      {"value no number",
       materials("roughness=\"0.250\"", "roughness=\"abc\""),
       false,
       {"materials.xml: line 12", "roughness=\"abc\" is no number"}},
      {"value with a comma",
       materials("roughness=\"0.250\"", "roughness=\"0,250\""),
       false,
       {"roughness=\"0,250\" is no number"}},
      {"value out of range",
       materials("roughness=\"0.250\"", "roughness=\"25\""),
       false,
       {"roughness=\"25\" is outside [0, 1]"}},
      {"value NaN", materials("sss=\"0.08\"", "sss=\"nan\""), false, {"sss=\"nan\" is no number"}},
      {"attribute twice",
       materials("sss=\"0.08\"", "sss=\"0.08\" sss=\"0.9\""),
       false,
       {"not well-formed XML|attribute 'sss' occurs twice"}},
      {"another encoding",
       materials("specular_encoding=\"srgb-f0\"", "specular_encoding=\"ior\""),
       false,
       {"specular_encoding=\"ior\" is not known", "srgb-f0"}},
      {"no materials",
       [](Square& s) { s.bake.materials = s.folder / "none.xml"; },
       false,
       {"none.xml", "no such file"}},
      {"picture missing", [](Square& s) { fs::remove(s.folder / "p.png"); }, false, {"p.png"}},
      {"picture truncated", [](Square& s) { fs::resize_file(s.folder / "p.png", 60); }, false, {"p.png"}},
      {"NaN in the normal map",
       [](Square& s) {
         auto parts = read_exr(s.folder / "n.exr");
         parts[0].image.values[5] = NAN;
         write_exr(s.folder / "n.exr", parts, {});
       },
       false,
       {"n.exr: pixel (1, 0)", "is not a finite number"}},
      {"normal map of one channel",
       [](Square& s) {
         write_exr(s.folder / "n.exr", {{"n", {"Y"}, ExrPart::Type::kHalf, Image(8, 8, 1)}}, {});
       },
       false,
       {"n.exr", "needs 3 channels, this has 1"}},
      {"bad normals option",
       [](Square& s) { s.bake.normals = "vulkan"; },
       false,
       {"--normals", "'vulkan' is not known"}},
      {"model over a user's folder",
       [](Square& s) { s.bake.output = s.folder.path(); },
       false,
       {"was not written by this program"}},
  };
}

TEST(LabelBake, HostileInputsAreRefusedInWordsAndLeaveNothing) {
  for (const Hostile& hostile : hostile_inputs()) {
    SCOPED_TRACE(hostile.name);
    Square square;
    if (!hostile.is_label) label_scan(square.label);
    hostile.damage(square);
    const size_t before = entries_of(square.folder.path());
    const std::string message = input_error_of([&] {
      if (hostile.is_label)
        label_scan(square.label);
      else
        bake_scan(square.bake);
    });
    EXPECT_EQ(message.find('\n'), std::string::npos);
    for (const std::string& part : hostile.message) {
      const size_t bar = part.find('|');
      EXPECT_TRUE(message.find(part.substr(0, bar)) != std::string::npos ||
                  (bar != std::string::npos && message.find(part.substr(bar + 1)) != std::string::npos))
          << "\"" << part << "\" is not in: " << message;
    }
    EXPECT_EQ(entries_of(square.folder.path()), before) << "something was left behind";
  }
}

const std::string kProgram = OHB_BINARY_DIR "/bin/openhumanbrdf";

/// Starts `openhumanbrdf bake` of the square in a process of its own, which may write files of that size
/// only.
pid_t start_bake(const Square& square, rlim_t largest_file) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  if (!std::freopen("/dev/null", "w", stdout)) ::_exit(126);
  // The kernel refuses to write beyond the limit, as a full disk would.
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{largest_file, largest_file};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  ::execl(kProgram.c_str(), kProgram.c_str(), "bake", square.bake.scan.c_str(), "--regions",
          square.bake.regions.c_str(), "-o", square.bake.output.c_str(), "--json", nullptr);
  ::_exit(127);
}

int exit_code_of(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(LabelBake, FullDiskIsToldApartAndLeavesNothing) {
  Square square;
  label_scan(square.label);
  const size_t before = entries_of(square.folder.path());
  // Where in a file the disk is full must not matter: header, texels, or what buffers hold back to the end.
  for (rlim_t largest_file : {20, 300, 600}) {
    EXPECT_EQ(exit_code_of(start_bake(square, largest_file)), kExitTryAgain) << largest_file;
    EXPECT_EQ(entries_of(square.folder.path()), before);
  }
  EXPECT_EQ(exit_code_of(start_bake(square, RLIM_INFINITY)), kExitDone);
  EXPECT_EQ(entries_of(square.folder.path()), before + 1);
}

TEST(LabelBake, KilledHalfwayLeavesNoModel) {
  Square square;
  write_small_png(square.folder / "p.png", 3, 1024);
  label_scan(square.label);
  const pid_t child = start_bake(square, RLIM_INFINITY);
  ::usleep(100000);
  ::kill(child, SIGKILL);
  if (exit_code_of(child) == kExitDone) GTEST_SKIP() << "the bake was faster than the kill";
  EXPECT_FALSE(fs::exists(square.bake.output));
  bake_scan(square.bake);  // and it can be made afterwards
  EXPECT_EQ(read_model(square.bake.output).sets.size(), 1u);
}

}  // namespace
}  // namespace ohb
