#include "dataset/commands/label_rules.h"

#include "dataset/commands/label.h"
#include "dataset/commands/name_words.h"
#include "dataset/labelling/face_colours.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/lab_colour.h"
#include "tests/support/scan_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

TEST(LabelRules, GlobsKnowStarsQuestionMarksAlternativesAndNoCase) {
  EXPECT_TRUE(matches_glob("*hair*", "Long_Hair_01"));
  EXPECT_TRUE(matches_glob("a*b*c", "aXXbYYc"));
  EXPECT_FALSE(matches_glob("a*b*c", "aXXbYY"));
  EXPECT_TRUE(matches_glob("skin|bod?", "body"));
  EXPECT_FALSE(matches_glob("bod?", "bod"));
  EXPECT_TRUE(matches_glob("*", ""));
  EXPECT_FALSE(matches_glob("tee", "teeth"));
  EXPECT_TRUE(matches_glob(std::string(200, '*') + "b", std::string(5000, 'a') + "b"));  // no blow-up
}

TEST(LabelRules, NamesAreSplitIntoTheirWords) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(words_of_name("Wolf3D_Headwear.001"), (Words{"wolf", "d", "headwear"}));
  EXPECT_EQ(words_of_name("LeftArm"), (Words{"left", "arm"}));
  EXPECT_EQ(words_of_name("HAIRBand-2 SKIN"), (Words{"hair", "band", "skin"}));
  EXPECT_EQ(words_of_name("LArm"), (Words{"l", "arm"}));
  EXPECT_EQ(words_of_name("M\xc3\xa4"
                          "dchen"),
            (Words{"m\xc3\xa4"
                   "dchen"}));
  EXPECT_EQ(words_of_name("_12."), Words{});
  EXPECT_EQ(matching_word("skin|head", {"head"}), "head");
  EXPECT_EQ(matching_word("lash", {"eye", "lashes"}), "lash");
  EXPECT_EQ(matching_word("*shirt", {"tshirts"}), "*shirt");
  EXPECT_EQ(matching_word("running shoe", {"red", "running", "shoes"}), "running shoe");
  EXPECT_EQ(matching_word("running shoe", {"shoe", "running"}), "");
  EXPECT_EQ(matching_word("", {"skin"}), "");
}

/// The class that the shipped rules give a name: "skin", ..., or "" where they say nothing.
std::string class_by_name(const std::string& name) {
  static const LabelRules rules = read_label_rules(program_file("assets/rules_by_name.xml"));
  Scan scan;
  scan.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  scan.corners = {{0}, {1}, {2}};
  scan.face_begin = {0, 3};
  scan.face_material = scan.face_group = {0};
  scan.materials.resize(1);
  scan.materials[0].name = name;
  scan.groups = {"default"};
  RuleOutcome outcome;
  const uint8_t found = apply_rules(rules, scan, {}, outcome).at(0);
  return found == kUnlabelled ? "" : kClassNames[found];
}

TEST(LabelRules, ShippedNamesMatchWholeWords) {
  const std::pair<const char*, std::vector<const char*>> table[] = {
      {"skin",
       {"Wolf3D_Head", "Wolf3D_Skin", "Std_Skin_Body", "body", "Face.001", "EyeLeft", "Eyes", "Std_Nails",
        "Wolf3D_Teeth", "leftHand", "feet", "Fingernails", "eye_shadow", "eyeshadow"}},
      {"hair",
       {"Wolf3D_Hair", "hair_01", "Eyebrows", "eyebrow001", "eyelashes01", "Hair_Braid", "Beard", "ponytail",
        "body_hair", "head_hair", "LongHair", "hair cap"}},
      {"fabric", {"Headwear",  "Wolf3D_Headwear",   "Wolf3D_Facewear", "Face_Mask",    "hairband",
                  "Hair_Band", "bodysuit",          "body_suit",       "skinny_jeans", "tshirt",
                  "TShirt",    "raincoat",          "Knee_Socks",      "handwear",     "headscarf",
                  "head_band", "Wolf3D_Outfit_Top", "sweatpants",      "underwear",    "neck_tie",
                  "sneakers",  "hair_tie",          "fur_coat",        "legwear"}},
      {"leather",
       {"shoes", "Footwear", "Wolf3D_Outfit_Footwear", "handbag", "Hand_Bag", "leather_jacket", "leatherette",
        "Boots", "belt", "foot_wear_leather", "suede_gloves"}},
      {"", {"Eyeglasses", "Eye_Glasses",  "Headphones", "head_phones", "hairclip",
            "hair_clip",  "Hairpins",     "Necklace",   "earring",     "ear_ring",
            "wristwatch", "default",      "chair",      "sheepskin",   "snakeskin_pattern",
            "sunglasses", "Material.003", "surface",    "handle",      "headset",
            "army",       "legend",       "football",   "heart"}}};
  for (const auto& [wanted, names] : table)
    for (const char* name : names) EXPECT_EQ(class_by_name(name), wanted) << name;
}

TEST(LabelRules, TheReportSaysWhichWordDecided) {
  const TemporaryFolder folder;
  write_bytes(folder / "m.mtl", "newmtl Wolf3D_Head\nnewmtl Hair_Tie\n");
  LabelJob job;
  job.scan = write_bytes(folder / "s.obj", "mtllib m.mtl\nusemtl Wolf3D_Head\n" + std::string(kQuadObj) +
                                               "usemtl Hair_Tie\nf 1/1 2/2 3/3\n");
  job.output = folder / "regions";
  const std::string text = to_text(label_scan(job));
  EXPECT_NE(text.find("skin: 'head' in Wolf3D_Head"), std::string::npos) << text;
  EXPECT_NE(text.find("fabric: 'hair tie' in Hair_Tie"), std::string::npos) << text;
}

TEST(LabelRules, LabIsThatOfTheStandard) {
  const Vec3f white = linear_to_lab({1, 1, 1}), red = linear_to_lab({1, 0, 0});
  EXPECT_NEAR(white.x, 100, 0.01f);
  EXPECT_NEAR(white.y, 0, 0.02f);
  EXPECT_NEAR(white.z, 0, 0.02f);
  EXPECT_NEAR(red.x, 53.24f, 0.01f);
  EXPECT_NEAR(red.y, 80.09f, 0.02f);
  EXPECT_NEAR(red.z, 67.20f, 0.02f);
}

/// Four quads side by side in u, of two materials and two groups; the picture is red left and blue right.
struct FourQuads {
  TemporaryFolder folder;
  Scan scan;
  FourQuads() {
    Image picture(8, 2, 3);
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 8; ++x) picture.pixel(x, y)[x < 4 ? 0 : 2] = 1;
    write_png(folder / "p.png", picture);
    write_bytes(folder / "s.mtl", "newmtl Skin_A\nmap_Kd p.png\nnewmtl cloth\nmap_Kd p.png\n");
    std::string obj = "mtllib s.mtl\n";
    for (int i = 0; i <= 4; ++i)
      for (int y : {0, 150})
        obj += "v " + std::to_string(i) + " " + std::to_string(y) + " 0\nvt " + std::to_string(i / 4.0) +
               " " + std::to_string(y / 150) + "\n";
    for (int i = 0; i < 4; ++i) {
      if (i % 2 == 0) obj += i == 0 ? "g top\n" : "g bottom\n";
      obj += i % 2 == 0 ? "usemtl Skin_A\nf" : "usemtl cloth\nf";
      for (int corner : {2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2})
        obj += " " + std::to_string(corner) + "/" + std::to_string(corner);
      obj += "\n";
    }
    scan = read_scan(write_bytes(folder / "s.obj", obj));
  }
  std::vector<uint8_t> classes_by(const std::string& xml, RuleOutcome* out = nullptr) {
    const LabelRules rules = read_label_rules(write_bytes(folder / "rules.xml", xml));
    RuleOutcome outcome;
    const auto classes = apply_rules(
        rules, scan, rules.use_colour() ? mean_face_colours(scan) : std::vector<Vec3f>(), outcome);
    if (out) *out = outcome;
    return classes;
  }
};

TEST(LabelRules, EachConditionTakesItsFacesAndLaterRulesWin) {
  FourQuads quads;
  using Classes = std::vector<uint8_t>;
  const auto rules = [](const std::string& inside) {
    return "<rules schema=\"1.0\" default=\"fabric\">" + inside + "</rules>";
  };
  EXPECT_EQ(quads.classes_by(rules("<rule class='skin' material='skin*'/>")), (Classes{0, 2, 0, 2}));
  EXPECT_EQ(quads.classes_by(rules("<rule class='hair' group='TOP'/>")), (Classes{1, 1, 2, 2}));
  EXPECT_EQ(quads.classes_by(rules("<rule class='hair' name='top|cloth'/>")), (Classes{1, 1, 2, 1}));
  EXPECT_EQ(quads.classes_by(rules("<rule class='hair' name='top' material='cloth'/>")),
            (Classes{2, 1, 2, 2}));
  EXPECT_EQ(quads.classes_by(rules("<rule class='leather' uv_polygon='0.2,0 0.7,0 0.7,1 0.2,1'/>")),
            (Classes{2, 3, 3, 2}));
  EXPECT_EQ(quads.classes_by(rules(
                "<rule class='leather' colour_space='srgb' colour_low='.9,0,0' colour_high='1,.1,.1'/>")),
            (Classes{3, 3, 2, 2}));
  EXPECT_EQ(quads.classes_by(rules(
                "<rule class='hair' colour_space='lab' colour_low='20 50 -120' colour_high='40 90 -90'/>")),
            (Classes{2, 2, 1, 1}));
  RuleOutcome outcome;
  EXPECT_EQ(quads.classes_by(rules("<rule class='skin' material='*'/><rule class='hair' group='bottom'/>"),
                             &outcome),
            (Classes{0, 0, 1, 1}));
  EXPECT_EQ(outcome.matched, (std::vector<uint64_t>{4, 2}));
  EXPECT_EQ(outcome.rule_of_face, (std::vector<int>{0, 0, 1, 1}));
}

TEST(LabelRules, MeanColourOfAFaceIsThatOfItsTexels) {
  FourQuads quads;
  const std::vector<Vec3f> colours = mean_face_colours(quads.scan);
  EXPECT_EQ(colours[0].x, 1.0f);
  EXPECT_EQ(colours[0].z, 0.0f);
  EXPECT_EQ(colours[3].z, 1.0f);
}

struct BadRules {
  const char* xml;
  std::vector<std::string> message;
};

TEST(LabelRules, RefusesMalformedRulesInWords) {
  const std::vector<BadRules> table = {
      {"", {"rules.xml", "the file is empty"}},
      {"<rules", {"rules.xml", "not well-formed XML"}},
      {"<regeln/>", {"root element is <regeln>, expected <rules>"}},
      {"<rules/>", {"neither a rule nor a default class"}},
      {"<rules default=\"fur\"/>", {"default=\"fur\" is no class", "skin, hair, fabric or leather"}},
      {"<rules>\n<rool class='skin'/></rules>", {"line 2", "<rool> is not known inside <rules>"}},
      {"<rules><rule material='a'/></rules>", {"<rule> has no attribute 'class'"}},
      {"<rules><rule class='skin'/></rules>", {"the rule has no condition"}},
      {"<rules><rule class='skin' except='wear'/></rules>", {"except without words"}},
      {"<rules><rule class='skin' materail='a'/></rules>", {"unknown attribute 'materail'", "spelling"}},
      {"<rules><rule class='skin' group='a' group='b'/></rules>", {"attribute 'group' occurs twice"}},
      {"<rules><rule class='skin' uv_polygon='0,0 1,0'/></rules>",
       {"uv_polygon has 2 points", "three or more"}},
      {"<rules><rule class='skin' uv_polygon='0,0 1'/></rules>",
       {"uv_polygon has 3 numbers", "write 2 a point"}},
      {"<rules><rule class='skin' uv_polygon='0,0 1,0 x,1'/></rules>", {"\"x\" is no number"}},
      {"<rules><rule class='skin' uv_polygon='0,0 1,0 nan,1'/></rules>", {"\"nan\" is no number"}},
      {"<rules><rule class='skin' colour_low='0 0 0' colour_high='1 1 1'/></rules>",
       {"no attribute 'colour_space'"}},
      {"<rules><rule class='skin' colour_space='hsv' colour_low='0 0 0' colour_high='1 1 1'/></rules>",
       {"colour_space=\"hsv\" is not known", "srgb or lab"}},
      {"<rules><rule class='skin' colour_space='lab' colour_low='0 0 9' colour_high='1 1 1'/></rules>",
       {"colour_low exceeds colour_high"}},
      {"<rules><rule class='skin' colour_space='lab' colour_low='0 0 0 1 1 1' colour_high='1 1 1'/></rules>",
       {"colour_low is not one colour"}},
  };
  const TemporaryFolder folder;
  for (const BadRules& bad : table) {
    SCOPED_TRACE(bad.xml);
    const std::string message =
        input_error_of([&] { read_label_rules(write_bytes(folder / "rules.xml", bad.xml)); });
    for (const std::string& part : bad.message) expect_message(message, {part});
  }
}

// The classes of the parts of the optional humans, which their parts.json tells too.
constexpr const char* kPartsRules =
    "<rules schema='1.0'>"
    "<rule class='skin' material='skin|eyes'/><rule class='hair' material='hair|brows|lashes'/>"
    "<rule class='fabric' material='garment|socks'/><rule class='leather' material='shoes|jacket'/>"
    "</rules>";

TEST(LabelRules, PartsOfTheHumansByMaterialName) {
  OHB_SHARED_DATA_OR_SKIP(humans, "humans");
  const TemporaryFolder folder;
  LabelJob job;
  job.scan = humans / "f33_leatherjacket/f33_leatherjacket.obj";
  job.rules = write_bytes(folder / "parts.xml", kPartsRules);
  job.output = folder / "regions";
  const LabelReport report = label_scan(job);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_EQ(report.unlabelled.faces, 0u);
  EXPECT_GT(report.classes[kLeather].area / report.total_area, 0.3);
}

TEST(LabelRules, PartsOfAHumanByTheShippedNames) {
  OHB_SHARED_DATA_OR_SKIP(humans, "humans");
  const Scan scan = read_scan(humans / "m48_suit/m48_suit.obj");
  const TemporaryFolder folder;
  RuleOutcome outcome;
  const auto by_names =
      apply_rules(read_label_rules(program_file("assets/rules_by_name.xml")), scan, {}, outcome);
  const auto by_parts =
      apply_rules(read_label_rules(write_bytes(folder / "parts.xml", kPartsRules)), scan, {}, outcome);
  EXPECT_EQ(by_names, by_parts);
}

TEST(LabelRules, SharedFaultOfNames) {
  OHB_SHARED_DATA_OR_SKIP(faults, "faults");
  const TemporaryFolder folder;
  LabelJob job;
  job.scan = faults / "13-names-head-face-eye-are-skin/a.obj";
  job.output = folder / "regions";
  EXPECT_EQ(label_scan(job).classes[kSkin].faces, 0u);
}

TEST(LabelRules, ShippedRulesAreWellFormed) {
  EXPECT_GE(read_label_rules(program_file("assets/rules_by_name.xml")).rules.size(), 4u);
}

}  // namespace
}  // namespace ohb
