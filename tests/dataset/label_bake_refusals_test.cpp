// label and bake refuse what they cannot use, in words, and leave nothing behind.
#include <functional>

#include "dataset/commands/bake_scan.h"
#include "dataset/commands/label.h"
#include "dataset/model/error.h"
#include "tests/dataset/labelled_square.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

namespace fs = std::filesystem;

struct Hostile {
  const char* name;
  std::function<void(Square&)> damage;
  bool is_label;  // label fails; else bake after a good label
  std::vector<std::string> message;
};

std::vector<Hostile> hostile_face_files() {
  const auto faces = [](const std::string& text) {
    return [text](Square& s) { write_bytes(s.folder / "faces.txt", text); };
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
  };
}

std::vector<Hostile> hostile_choices() {
  return {
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
  };
}

std::vector<Hostile> hostile_ways_to_label() {
  return {
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
  };
}

std::vector<Hostile> hostile_label_outputs() {
  return {
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
  };
}

std::vector<Hostile> hostile_regions() {
  return {
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
  };
}

std::vector<Hostile> hostile_materials() {
  const auto changed = [](const std::string& from, const std::string& to) {
    return [from, to](Square& s) { edit(s.folder / "materials.xml", from, to); };
  };
  return {
      {"missing class",
       changed("<material class=\"leather\" specular=\"0.224\" roughness=\"0.250\" sss=\"0.00\"/>", ""),
       false,
       {"materials.xml", "no material for class 'leather'"}},
      {"class twice",
       changed("class=\"leather\"", "class=\"skin\""),
       false,
       {"a second material for class 'skin'"}},
      {"unknown class",
       changed("class=\"leather\"", "class=\"metal\""),
       false,
       {"class=\"metal\" is not known"}},
      {"value no number",
       changed("roughness=\"0.250\"", "roughness=\"abc\""),
       false,
       {"materials.xml: line 12", "roughness=\"abc\" is no number"}},
      {"value with a comma",
       changed("roughness=\"0.250\"", "roughness=\"0,250\""),
       false,
       {"roughness=\"0,250\" is no number"}},
      {"value out of range",
       changed("roughness=\"0.250\"", "roughness=\"25\""),
       false,
       {"roughness=\"25\" is outside [0, 1]"}},
      {"value NaN", changed("sss=\"0.08\"", "sss=\"nan\""), false, {"sss=\"nan\" is no number"}},
      {"attribute twice",
       changed("sss=\"0.08\"", "sss=\"0.08\" sss=\"0.9\""),
       false,
       {"not well-formed XML|attribute 'sss' occurs twice"}},
      {"another encoding",
       changed("specular_encoding=\"srgb-f0\"", "specular_encoding=\"ior\""),
       false,
       {"specular_encoding=\"ior\" is not known", "srgb-f0"}},
  };
}

std::vector<Hostile> hostile_pictures() {
  return {
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
  std::vector<Hostile> inputs;
  for (const auto& some :
       {hostile_face_files(), hostile_choices(), hostile_ways_to_label(), hostile_label_outputs(),
        hostile_regions(), hostile_materials(), hostile_pictures()})
    inputs.insert(inputs.end(), some.begin(), some.end());
  for (const Hostile& hostile : inputs) {
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

}  // namespace
}  // namespace ohb
