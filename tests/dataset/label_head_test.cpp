// What lies on the head and hangs from it: hats, hair of the colour of skin, braids on a jacket; and bits of
// another class on a garment.
#include <algorithm>
#include <functional>

#include "dataset/commands/label.h"
#include "dataset/labelling/enclosed_patches.h"
#include "dataset/labelling/labeller.h"
#include "tests/support/tube_person.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

using Where = std::function<bool(double angle, double y_cm)>;  // as tube_class

void paint(TubePerson& person, const Where& where, Vec3f srgb, MaterialClass material_class) {
  constexpr double kPi = 3.14159265358979;
  Image picture = read_image(person.folder / "tube.png");
  for (int y = 0; y < picture.height_px; ++y)
    for (int x = 0; x < picture.width_px; ++x) {
      const double height = kTubeHeight_cm * (1 - (y + 0.5) / picture.height_px);
      if (!where(2 * kPi * ((x + 0.5) / picture.width_px - 0.5), height)) continue;
      const float grain = 0.01f * static_cast<float>((x * 7919 + y * 104729) % 101 - 50) / 50;
      for (int c = 0; c < 3; ++c) picture.pixel(x, y)[c] = srgb[c] + grain;
    }
  write_png(person.folder / "tube.png", picture);
  const FaceGraph graph = face_graph({person.scan, 1});
  for (size_t f = 0; f < graph.size(); ++f)
    if (where(std::atan2(graph.centre_cm[f].x, graph.centre_cm[f].z), graph.centre_cm[f].y))
      person.truth[f] = material_class;
}

struct Answered {
  double before = 0, after = 0;  // share of the area that is right
  bool asks_of_head = false;
};

/// Labels and answers all questions as the truth has it.
Answered answered(const TubePerson& person) {
  const std::vector<double> area = face_areas(person.scan);
  Labeller labeller({person.scan, 1});
  const Labelling labels = labeller.solve({});
  Answered result;
  result.before = compare_with_truth(labels.face_class, person.truth, area).accuracy;
  std::vector<Stroke> strokes;
  for (const GarmentQuestion& question : labels.questions) {
    std::array<double, kClassCount> of{};
    for (size_t f = 0; f < area.size(); ++f)
      if (labeller.garments().of_face[f] == question.garment) of[person.truth[f]] += area[f];
    const auto most = std::max_element(of.begin(), of.end()) - of.begin();
    strokes.push_back(stroke_of_answer(labeller, question.garment, static_cast<MaterialClass>(most)));
    if (labeller.garments().garments[question.garment].is_on_head) result.asks_of_head = true;
  }
  result.after = compare_with_truth(labeller.solve(strokes).face_class, person.truth, area).accuracy;
  return result;
}

/// Hats were hair, and nobody asked.
TEST(LabelHead, AHatIsRightOrAskedAbout) {
  const Vec3f colours[] = {{0.75f, 0.70f, 0.62f}, {0.20f, 0.30f, 0.55f}, {0.45f, 0.43f, 0.40f}};
  for (const Vec3f& colour : colours) {
    TubePerson person;
    make_tube_person(48, 120, person);
    paint(
        person, [](double, double y_cm) { return y_cm > 157; }, colour, kFabric);
    const Answered labels = answered(person);
    EXPECT_GT(labels.after, 0.98) << colour.x << " before " << labels.before << labels.asks_of_head;
  }
}

/// Hair of nearly the colour of skin was skin, and nobody asked.
TEST(LabelHead, HairOfNearlyTheColourOfSkinIsRightOrAskedAbout) {
  TubePerson person;
  make_tube_person(48, 120, person);
  paint(
      person, [](double angle, double y_cm) { return tube_class(angle, y_cm) == kHair; },
      {0.66f, 0.50f, 0.36f}, kHair);
  const Answered labels = answered(person);
  EXPECT_GT(labels.after, 0.98) << " before " << labels.before << labels.asks_of_head;
}

/// The front of a head that looks sideways is hair. Where that had a colour that skin has, too, it was taken
/// for the skin, and face and arms for cloth.
TEST(LabelHead, TheFaceOfATurnedHeadIsFound) {
  for (const double turned : {-1.6, -1.0, 0.0, 1.2, 1.8}) {
    TubePerson person;
    make_tube_person(48, 120, person);
    const auto head_class = [&](double angle, double y_cm) {
      return tube_class(std::remainder(angle - turned, 6.28318530717959), y_cm);
    };
    const auto above = [](double y_cm) { return y_cm > 150; };
    paint(
        person, [&](double angle, double y_cm) { return above(y_cm) && head_class(angle, y_cm) == kHair; },
        {0.40f, 0.28f, 0.19f}, kHair);
    paint(
        person, [&](double angle, double y_cm) { return above(y_cm) && head_class(angle, y_cm) == kSkin; },
        tube_srgb(kSkin, 155), kSkin);
    EXPECT_GT(answered(person).before, 0.97) << turned;
  }
}

TEST(LabelHead, OrdinaryHairAndAFaceAreNotAskedAbout) {
  TubePerson person;
  make_tube_person(48, 120, person);
  EXPECT_FALSE(answered(person).asks_of_head);
  TubePerson bald;
  make_tube_person(48, 120, bald, true);
  EXPECT_FALSE(answered(bald).asks_of_head);
}

/// A braid on a dark jacket looks much like it; what is nearer to the hair's colour is of the hair.
TEST(LabelHead, ABraidOnADarkJacketHangsFromTheHead) {
  TubePerson person;
  make_tube_person(48, 120, person);
  const auto is_braid = [](double angle, double y_cm) {
    return std::abs(angle) > 2.8 && y_cm > 110 && y_cm < 161;
  };
  const Vec3f hair{0.16f, 0.11f, 0.08f};
  paint(
      person, [](double, double y_cm) { return y_cm > 85 && y_cm < 146; }, {0.26f, 0.17f, 0.12f}, kLeather);
  paint(person, is_braid, hair, kHair);
  const FaceFeatures features = face_features({person.scan, 1});
  const StartCues cues = start_cues(features);
  constexpr int kJoinedLow = 6;
  ASSERT_STREQ(kCueNames[kJoinedLow], "hair_joined_low");
  double braid = 0, braid_joined = 0, jacket_joined = 0;
  for (size_t f = 0; f < features.size(); ++f) {
    if (features.graph.centre_cm[f].y > 140) continue;
    const bool is_joined = cues.cues[f][kJoinedLow] > 0;
    if (person.truth[f] == kHair) ++braid;
    (person.truth[f] == kHair ? braid_joined : jacket_joined) += is_joined;
  }
  ASSERT_GT(braid, 50);
  EXPECT_GT(braid_joined, 0.9 * braid);
  EXPECT_LT(jacket_joined, 0.1 * braid);
}

/// A sheet of 40 x 40 cm.
Scan sheet(int side) {
  Scan scan;
  for (int z = 0; z <= side; ++z)
    for (int x = 0; x <= side; ++x)
      scan.positions.push_back({static_cast<float>(x), 0, static_cast<float>(z)});
  scan.face_begin.push_back(0);
  for (int z = 0; z < side; ++z)
    for (int x = 0; x < side; ++x) {
      const uint32_t v = static_cast<uint32_t>(z * (side + 1) + x), next = static_cast<uint32_t>(side + 1);
      for (uint32_t corner : {v, v + 1, v + next + 1, v + next}) scan.corners.push_back({corner});
      scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    }
  return scan;
}

TEST(LabelPatches, BitsOnAGarmentAreOfItUnlessTheyAreTold) {
  constexpr int kSide = 40;
  FaceFeatures features;
  features.graph = face_graph({sheet(kSide), 1});
  features.lab.assign(features.size(), {40, 15, 15});
  const auto changes_of = [&](uint8_t around, uint8_t inside, int size, bool is_told = false) {
    std::vector<uint8_t> face_class(features.size(), around);
    std::vector<bool> told(features.size(), false);
    for (int z = 18; z < 18 + size; ++z)
      for (int x = 18; x < 18 + size; ++x) face_class[static_cast<size_t>(z * kSide + x)] = inside;
    told[18 * kSide + 18] = is_told;
    return enclosed_labels(features, face_class, told);
  };
  for (uint8_t inside : {kFabric, kHair}) {
    const std::vector<LabelChange> changes = changes_of(kLeather, inside, 3);
    ASSERT_EQ(changes.size(), 9u);
    EXPECT_EQ(changes[0].material_class, kLeather);
  }
  EXPECT_EQ(changes_of(kFabric, kLeather, 3).size(), 9u);
  EXPECT_TRUE(changes_of(kFabric, kLeather, 3, true).empty()) << "it was told";
  EXPECT_TRUE(changes_of(kFabric, kLeather, 8).empty()) << "too large for a bit";
  EXPECT_TRUE(changes_of(kFabric, kSkin, 3).empty()) << "hands come out of sleeves";
  EXPECT_TRUE(changes_of(kSkin, kLeather, 3).empty()) << "straps of sandals";
}

}  // namespace
}  // namespace ohb
