#include "dataset/labelling/garment_questions.h"

#include <algorithm>
#include <cmath>

namespace ohb::labelling {
namespace {

constexpr float kTold = 0.995f;  // of a garment that a stroke names
constexpr float kOwnLook = 9;    // look_difference of a stroke that speaks for the garment it lies on
constexpr float kOwnVariation = 2;
constexpr float kHanging = 0.8f;  // of what hangs from the hair, looks like it and is no large garment
constexpr float kHairLook = 4, kHangingArea_share = 0.2f, kHangingWidth_heads = 1.2f;

struct HairTouch {
  float border_cm = 0, away_cm = 0;  // with hair; mean distance from the head's axis
};

std::vector<HairTouch> touches_of(const FaceGraph& graph, const Garments& garments, const BodyFrame& frame,
                                  const std::vector<uint8_t>& part) {
  std::vector<HairTouch> touches(garments.garments.size());
  for (const FaceEdge& edge : graph.edges)
    for (const auto& [f, other] : {std::pair(edge.a, edge.b), std::pair(edge.b, edge.a)})
      if (garments.of_face[f] != Garments::kNone && part[other] == kHair)
        touches[garments.of_face[f]].border_cm += edge.length_cm;
  for (size_t f = 0; f < graph.size(); ++f)
    if (garments.of_face[f] != Garments::kNone)
      touches[garments.of_face[f]].away_cm +=
          graph.area_cm2[f] / garments.garments[garments.of_face[f]].area_cm2 *
          std::hypot(graph.centre_cm[f].x - frame.head_x_cm, graph.centre_cm[f].z - frame.head_z_cm);
  return touches;
}

Appearance look_of_hair(const FaceFeatures& features, const std::vector<uint8_t>& part) {
  Appearance sum = Appearance::Zero();
  float area = 0;
  for (size_t f = 0; f < part.size(); ++f) {
    if (part[f] != kHair) continue;
    sum += features.graph.area_cm2[f] * features.appearance[f];
    area += features.graph.area_cm2[f];
  }
  return area > 0 ? Appearance(sum / area) : Appearance::Constant(1e4f);
}

/// The area that an answer may be expected to mend.
double worth_cm2(const GarmentQuestion& question) {
  return (1 - question.probability) * question.area_cm2;
}

}  // namespace

std::vector<ClassValues> garment_classes(const FaceFeatures& features, const Garments& garments,
                                         const BodyFrame& frame, const std::vector<uint8_t>& part,
                                         const LabelModel& model) {
  const std::vector<HairTouch> touches = touches_of(features.graph, garments, frame, part);
  const Appearance hair = look_of_hair(features, part);
  float all_cm2 = 0;
  for (float area : features.graph.area_cm2) all_cm2 += area;
  std::vector<ClassValues> classes;
  for (size_t g = 0; g < touches.size(); ++g) {
    const Garment& garment = garments.garments[g];
    const float leather = garment.is_shoe ? model.leather_shoes : model.leather_garments;
    const bool is_hanging = touches[g].border_cm > 1 && look_difference(garment.look, hair) < kHairLook &&
                            touches[g].away_cm < kHangingWidth_heads * frame.head_cm &&
                            garment.area_cm2 < kHangingArea_share * all_cm2;
    const float rest = is_hanging ? 1 - kHanging : 1;
    classes.push_back({0, 1 - rest, rest * (1 - leather), rest * leather});
  }
  return classes;
}

void hear_strokes(const FaceFeatures& features, double unit_cm, const Garments& garments,
                  const std::vector<Stroke>& strokes, std::vector<ClassValues>& classes) {
  std::vector<std::array<bool, kClassCount>> told(classes.size(), {false, false, false, false});
  for (const Stroke& stroke : strokes) {
    std::vector<float> on_cm2(classes.size(), 0);  // each garment, where the stroke looks like it
    std::vector<bool> is_middle(classes.size(), false);
    float covered_cm2 = 0;
    for (uint32_t f : faces_of_stroke(stroke, features.graph, unit_cm)) {
      const uint32_t g = garments.of_face[f];
      covered_cm2 += features.graph.area_cm2[f];
      if (g == Garments::kNone) continue;
      const Garment& garment = garments.garments[g];
      if (f == garment.face) is_middle[g] = true;
      if (look_difference(features.appearance[f], garment.look) <
          kOwnLook + kOwnVariation * garment.variation)
        on_cm2[g] += features.graph.area_cm2[f];
    }
    for (size_t g = 0; g < classes.size(); ++g)
      if (is_middle[g] || on_cm2[g] > 0.5f * covered_cm2) told[g][stroke.material_class] = true;
  }
  for (size_t g = 0; g < classes.size(); ++g) {
    if (std::count(told[g].begin(), told[g].end(), true) != 1) continue;
    for (int c = 0; c < kClassCount; ++c)
      classes[g][c] = told[g][c] ? kTold : (1 - kTold) / (kClassCount - 1);
  }
}

std::vector<GarmentQuestion> open_questions(const Garments& garments,
                                            const std::vector<ClassValues>& classes) {
  std::vector<GarmentQuestion> questions;
  for (size_t g = 0; g < classes.size(); ++g) {
    GarmentQuestion question;
    std::array<uint8_t, kClassCount> order = {kFabric, kLeather, kHair, kSkin};
    std::stable_sort(order.begin(), order.end(),
                     [&](uint8_t l, uint8_t r) { return classes[g][l] > classes[g][r]; });
    question.name = garments.garments[g].name;
    question.garment = g;
    question.now = order[0];
    question.rival = order[1];
    question.probability = classes[g][order[0]];
    question.area_cm2 = garments.garments[g].area_cm2;
    question.face = garments.garments[g].face;
    const bool is_told = question.probability >= kTold - 1e-4f;
    if (!is_told && worth_cm2(question) > kWorthAsking * garments.all_cm2) questions.push_back(question);
  }
  std::stable_sort(questions.begin(), questions.end(),
                   [](const auto& l, const auto& r) { return worth_cm2(l) > worth_cm2(r); });
  if (questions.size() > kMostQuestions) questions.resize(kMostQuestions);
  std::stable_sort(questions.begin(), questions.end(),
                   [](const auto& l, const auto& r) { return l.area_cm2 > r.area_cm2; });
  return questions;
}

}  // namespace ohb::labelling
