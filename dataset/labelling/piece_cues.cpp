#include "dataset/labelling/piece_cues.h"

#include <algorithm>
#include <cmath>

namespace ohb::labelling {
namespace {

constexpr float kLightness = 12, kHue = 6;  // what one material varies under shading
constexpr float kFar = 3;
constexpr float kLeastLeather = 0.03f;  // leather is dyed and embossed as cloth is: no look excludes it

/// Mean over faces, by area.
struct Mean {
  Appearance look = Appearance::Zero();
  float print = 0, behind_cm = 0, area_cm2 = 0;  // print: spread of a* and b* around a face, logarithmic
  float above = 0;                               // share of the area that lies above the eyes

  void add(const FaceFeatures& features, const BodyFrame& frame, uint32_t f) {
    const float area = features.graph.area_cm2[f];
    const Vec3f at = features.graph.centre_cm[f], spread = features.local_spread[f];
    area_cm2 += area;
    look += area * features.appearance[f];
    print += area * std::log(1 + std::hypot(spread.y, spread.z));
    behind_cm -= area * frame.before_axis_cm(at);
    above += area * (at.y > frame.eyes_cm);
  }
  void finish() {
    const float area = std::max(area_cm2, 1e-6f);
    look /= area;
    print /= area;
    behind_cm /= area;
    above /= area;
  }
};

float lightness_between(const Appearance& l, const Appearance& r) {
  return std::min(kFar, std::abs(l[0] - r[0]) / kLightness);
}
float hue_between(const Appearance& l, const Appearance& r) {
  return std::min(kFar, std::hypot(l[1] - r[1], l[2] - r[2]) / kHue);
}

/// Tanned hide: from dark to cognac.
float brown(const Appearance& look) {
  const float lightness = (look[0] - 28) / 14, a = (look[1] - 13) / 8, b = (look[2] - 17) / 9;
  return std::exp(-0.5f * (lightness * lightness + a * a + b * b));
}

std::vector<float> hair_borders_cm(const FaceGraph& graph, const Garments& garments,
                                   const std::vector<uint8_t>& part) {
  std::vector<float> border_cm(garments.garments.size(), 0);
  for (const FaceEdge& edge : graph.edges)
    for (const auto& [f, other] : {std::pair(edge.a, edge.b), std::pair(edge.b, edge.a)})
      if (garments.of_face[f] != Garments::kNone && part[other] == kHair && part[f] != kHair)
        border_cm[garments.of_face[f]] += edge.length_cm;
  return border_cm;
}

/// How much each piece is folded: mean 1 - cosine between its neighbouring faces, by their border. Brims and
/// the rims of hats fold the surface, hair lies on the head.
std::vector<float> folds_of(const FaceGraph& graph, const Garments& garments) {
  std::vector<float> fold(garments.garments.size(), 0), border_cm(fold.size(), 1e-6f);
  for (const FaceEdge& edge : graph.edges) {
    const uint32_t g = garments.of_face[edge.a];
    if (edge.is_bridge || g == Garments::kNone || garments.of_face[edge.b] != g) continue;
    fold[g] += edge.length_cm * (1 - dot(graph.normal[edge.a], graph.normal[edge.b]));
    border_cm[g] += edge.length_cm;
  }
  for (size_t g = 0; g < fold.size(); ++g) fold[g] /= border_cm[g];
  return fold;
}

HeadCues head_cues(const Mean& mean, bool is_hair, float fold) {
  return {1,
          static_cast<float>(is_hair),
          std::hypot(mean.look[1], mean.look[2]) / 20 - 0.5f,
          mean.look[0] / 50 - 0.5f,
          std::clamp(mean.look[3] - 1, -1.0f, 1.0f),
          mean.above - 0.5f,
          std::min(1.0f, 5 * fold)};
}

LeatherCues leather_cues(const Mean& mean) {
  const float light = mean.look[0] / 50 - 1, texture = std::clamp(mean.look[3] - 1, -1.0f, 1.0f);
  return {1,
          light,
          std::hypot(mean.look[1], mean.look[2]) / 30 - 1,
          texture,
          std::clamp(mean.print - 1, -1.0f, 1.0f),
          brown(mean.look),
          light * light,
          texture * texture};
}

}  // namespace

std::vector<PieceCues> piece_cues(const FaceFeatures& features, const Garments& garments,
                                  const BodyFrame& frame, const std::vector<uint8_t>& part) {
  Mean skin, hair;
  std::vector<Mean> means(garments.garments.size());
  for (uint32_t f = 0; f < features.size(); ++f) {
    const bool is_head = features.graph.centre_cm[f].y > frame.chin_cm;
    if (is_head && part[f] == kSkin && garments.of_face[f] == Garments::kNone) skin.add(features, frame, f);
    if (is_head && part[f] == kHair) hair.add(features, frame, f);
    if (garments.of_face[f] != Garments::kNone) means[garments.of_face[f]].add(features, frame, f);
  }
  skin.finish();
  hair.finish();
  const std::vector<float> border_cm = hair_borders_cm(features.graph, garments, part);
  const std::vector<float> fold = folds_of(features.graph, garments);
  std::vector<PieceCues> all(means.size());
  for (size_t g = 0; g < means.size(); ++g) {
    Mean& mean = means[g];
    mean.finish();
    const Garment& piece = garments.garments[g];
    const bool is_hair = piece.part == kHair;
    all[g].may_be_hair =
        is_hair || piece.is_on_head || (piece.part == kFabric && border_cm[g] > 1 && hair.area_cm2 > 0);
    all[g].bare = {1, lightness_between(mean.look, skin.look), hue_between(mean.look, skin.look),
                   mean.look[3] - skin.look[3], piece.is_on_head ? mean.above : 0};
    const float share = static_cast<float>(mean.area_cm2 / garments.all_cm2);
    all[g].hanging = {1, static_cast<float>(is_hair),
                      std::min(kFar, std::sqrt(look_difference(mean.look, hair.look))),
                      std::clamp(2 * mean.behind_cm / frame.head_cm, -1.0f, 1.0f), std::min(1.0f, 4 * share)};
    if (piece.is_on_head) all[g].head = head_cues(mean, is_hair, fold[g]);
    if (!piece.is_shoe) all[g].leather = leather_cues(mean);
  }
  return all;
}

float log_odds(float share) {
  return std::log(share / (1 - share));
}

ClassValues piece_classes(const Garment& piece, const PieceCues& cues, const PieceWeights& weights,
                          float leather_share) {
  const float skin = piece.part == kSkin ? probability_of(weights.bare, cues.bare) : 0;
  const float hair = !cues.may_be_hair  ? 0
                     : piece.is_on_head ? probability_of(weights.head, cues.head)
                                        : probability_of(weights.hanging, cues.hanging);
  const float garment = (1 - skin) * (1 - hair);
  const float odds = log_odds(piece.is_shoe ? kLeatherShoes : leather_share);
  const float leather =
      std::clamp(probability_of(weights.leather, cues.leather, odds), kLeastLeather, 1 - kLeastLeather);
  return {skin, (1 - skin) * hair, garment * (1 - leather), garment * leather};
}

}  // namespace ohb::labelling
