#include "dataset/labelling/start_cues.h"

#include <algorithm>
#include <cmath>

namespace ohb::labelling {

float hue_degrees(Vec3f lab) {
  return std::atan2(lab.z, lab.y) * 57.29578f;
}
float chroma(Vec3f lab) {
  return std::hypot(lab.y, lab.z);
}

namespace {

/// Standard deviations of L* and of a*, b* within one person's skin and hair, under shading.
constexpr float kSkinLightness = 15, kSkinHue = 5.5f, kHairLightness = 14, kHairHue = 7;
/// Of a turned head: by how many of them a face differs from the crown, the share of the front that does so
/// at most, and of the place where the face is found at least.
constexpr float kNotCrown = 1.6f, kFewBare = 0.5f, kMostlyBare = 0.9f, kMostTurned_degrees = 105;

/// 0 below `low`, 1 above `high`, smooth between.
float ramp(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

/// The value below which that share of the weight lies.
float weighted_quantile(std::vector<std::pair<float, float>> value_and_weight, float share = 0.5f) {
  std::sort(value_and_weight.begin(), value_and_weight.end());
  double total = 0, sum = 0;
  for (const auto& entry : value_and_weight) total += entry.second;
  for (const auto& entry : value_and_weight)
    if ((sum += entry.second) >= share * total) return entry.first;
  return 0;
}

/// The colour of one part of this person: medians of faces.
struct ColourSample {
  Vec3f lab;
  float area_cm2 = 0;  // 0: there is none
};

template <typename Predicate>
ColourSample sample_colour(const FaceFeatures& features, const Predicate& is_in) {
  std::vector<std::pair<float, float>> values[3];
  ColourSample sample;
  for (uint32_t f = 0; f < features.size(); ++f) {
    if (!is_in(f)) continue;
    sample.area_cm2 += features.graph.area_cm2[f];
    for (int i = 0; i < 3; ++i) values[i].emplace_back(features.lab[f][i], features.graph.area_cm2[f]);
  }
  for (int i = 0; i < 3; ++i) sample.lab[i] = weighted_quantile(values[i]);
  return sample;
}

/// Distance of colours in standard deviations of one material under shading and variation.
float distance(Vec3f lab, const ColourSample& sample, float lightness, float hue) {
  const Vec3f d = lab - sample.lab;
  return std::sqrt(d.x * d.x / (lightness * lightness) + (d.y * d.y + d.z * d.z) / (hue * hue));
}

/// 1 in the middle of a material, 0 beyond what it varies.
float near_by(float deviations) {
  return std::exp(-0.25f * deviations * deviations);
}

/// Colours that skin of any person has under white light: from pink to yellow, never grey.
bool is_skin_locus(Vec3f lab) {
  const float hue = hue_degrees(lab);
  return lab.x > 10 && lab.x < 95 && hue > 15 && hue < 85 && chroma(lab) > 6 && chroma(lab) < 50;
}
/// Colours that hair has undyed: black, grey, white, brown, red, blond.
bool is_hair_locus(Vec3f lab) {
  const float hue = hue_degrees(lab);
  return chroma(lab) < 9 || (hue > 10 && hue < 95);
}

bool is_in_head(const BodyFrame& body, Vec3f at) {
  return at.y > body.chin_cm - 0.1f * body.head_cm &&
         std::hypot(at.x - body.head_x_cm, at.z - body.head_z_cm) < 0.8f * body.head_cm;
}
bool is_crown(const BodyFrame& body, Vec3f at) {
  return at.y > body.eyes_cm + 0.35f * (body.top_cm - body.eyes_cm) && is_in_head(body, at);
}

/// How much of what a frame takes for the front of the face has a colour of skin, and not that of the crown.
double bare_share(const FaceFeatures& features, const BodyFrame& body, const ColourSample& crown) {
  double bare_cm2 = 0, all_cm2 = 1e-6;
  for (uint32_t f = 0; f < features.size(); ++f) {
    if (!is_face_front(features.graph, body, f)) continue;
    const Vec3f lab = features.lab[f];
    all_cm2 += features.graph.area_cm2[f];
    if (is_skin_locus(lab) && distance(lab, crown, kHairLightness, kHairHue) > kNotCrown)
      bare_cm2 += features.graph.area_cm2[f];
  }
  return bare_cm2 / all_cm2;
}

/// Turns the front of a head that looks aside. Hair covers the crown and the back of the head, and may have a
/// colour that skin has too: a front that is mostly of the crown's colour is no face if another is nearly
/// free of it. A hat or a bald head says nothing.
void find_front(const FaceFeatures& features, BodyFrame& body) {
  const ColourSample crown =
      sample_colour(features, [&](uint32_t f) { return is_crown(body, features.graph.centre_cm[f]); });
  if (bare_share(features, body, crown) > kFewBare) return;
  BodyFrame turned = body;
  double most = kMostlyBare;
  for (float degrees = -kMostTurned_degrees; degrees <= kMostTurned_degrees; degrees += 15) {
    turned.front = {std::sin(degrees / 57.29578f), 0, std::cos(degrees / 57.29578f)};
    if (const double share = bare_share(features, turned, crown); share > most) {
      most = share;
      body.front = turned.front;
    }
  }
}

class CueFinder {
 public:
  explicit CueFinder(const FaceFeatures& features)
      : features_(features), graph_(features.graph), body_(body_frame(features)) {}

  StartCues run();

 private:
  bool is_in_head(uint32_t f) const { return ohb::labelling::is_in_head(body_, graph_.centre_cm[f]); }
  /// A braid on a dark jacket looks much like it: only what is nearer to the jacket's colour ends it.
  bool is_torso(Vec3f lab) const {
    return distance(lab, torso_, 10, 5) < 2 &&
           distance(lab, hair_, kHairLightness, kHairHue) > distance(lab, torso_, kHairLightness, kHairHue);
  }
  void sample_parts();
  void measure_skin();
  void flood_hair();
  Cues cues_of(uint32_t f) const;

  const FaceFeatures& features_;
  const FaceGraph& graph_;
  const BodyFrame body_;
  ColourSample skin_, hair_, torso_;
  std::vector<float> skin_likeness_, hair_likeness_;
  std::vector<bool> in_hair_;
};

void CueFinder::sample_parts() {
  skin_ = sample_colour(features_, [&](uint32_t f) {
    return is_face_front(graph_, body_, f) && is_skin_locus(features_.lab[f]);
  });
  measure_skin();
  ColourSample bare = sample_colour(features_, [&](uint32_t f) {
    return is_crown(body_, graph_.centre_cm[f]) && skin_likeness_[f] > 0.5f;
  });
  hair_ = sample_colour(features_, [&](uint32_t f) {
    return is_crown(body_, graph_.centre_cm[f]) && skin_likeness_[f] < 0.5f;
  });
  if (hair_.area_cm2 < 0.3f * bare.area_cm2 || !is_hair_locus(hair_.lab)) hair_.area_cm2 = 0;
  if (!body_.is_whole) return;
  const float height = body_.top_cm - body_.ground_cm;
  torso_ = sample_colour(features_, [&](uint32_t f) {
    const float share = (graph_.centre_cm[f].y - body_.ground_cm) / height;
    return share > 0.55f && share < 0.8f && skin_likeness_[f] < 0.5f &&
           std::abs(graph_.centre_cm[f].x - body_.head_x_cm) < 0.12f * height && graph_.normal[f].z > 0;
  });
}

void CueFinder::measure_skin() {
  skin_likeness_.assign(graph_.size(), 0);
  if (!(skin_.area_cm2 > 0)) return;
  for (uint32_t f = 0; f < graph_.size(); ++f) {
    const float d = distance(features_.lab[f], skin_, kSkinLightness, kSkinHue);
    skin_likeness_[f] = 1 / (1 + std::exp(3 * (d - 2.3f)));
  }
}

/// Hair that hangs down from the head: faces of its colour that hair-coloured faces connect with the crown.
void CueFinder::flood_hair() {
  hair_likeness_.assign(graph_.size(), 0);
  in_hair_.assign(graph_.size(), false);
  if (!(hair_.area_cm2 > 0)) return;
  std::vector<uint32_t> front;
  for (uint32_t f = 0; f < graph_.size(); ++f) {
    float d = distance(features_.lab[f], hair_, kHairLightness, kHairHue);
    hair_likeness_[f] = 1 / (1 + std::exp(3 * (d - 2.2f)));
    if (graph_.centre_cm[f].y > body_.eyes_cm && is_in_head(f) && hair_likeness_[f] > 0.5f &&
        skin_likeness_[f] < 0.5f) {
      in_hair_[f] = true;
      front.push_back(f);
    }
  }
  for (size_t i = 0; i < front.size(); ++i)
    for (uint32_t n = graph_.first_neighbour[front[i]]; n < graph_.first_neighbour[front[i] + 1]; ++n) {
      const uint32_t f = graph_.neighbours[n].face;
      if (in_hair_[f] || hair_likeness_[f] < 0.5f || skin_likeness_[f] > 0.5f) continue;
      const bool is_below = graph_.centre_cm[f].y < body_.chin_cm;
      if (is_below && body_.is_whole && is_torso(features_.lab[f])) continue;
      if (is_below && std::hypot(graph_.centre_cm[f].x - body_.head_x_cm,
                                 graph_.centre_cm[f].z - body_.head_z_cm) > 1.2f * body_.head_cm)
        continue;
      if (length(features_.lab[f] - features_.lab[front[i]]) > 15) continue;
      in_hair_[f] = true;
      front.push_back(f);
    }
}

Cues CueFinder::cues_of(uint32_t f) const {
  constexpr float kFar = 6;  // standard deviations; beyond, all is equally far
  const Vec3f c = graph_.centre_cm[f], lab = features_.lab[f];
  const float skin =
      (skin_.area_cm2 > 0 ? std::min(kFar, distance(lab, skin_, kSkinLightness, kSkinHue)) : kFar) / kFar;
  const float hair =
      (hair_.area_cm2 > 0 ? std::min(kFar, distance(lab, hair_, kHairLightness, kHairHue)) : kFar) / kFar;
  const float head = is_in_head(f);
  const bool is_front = body_.before_axis_cm(c) > 0 && dot(graph_.normal[f], body_.front) > 0 &&
                        c.y > body_.chin_cm && c.y < body_.eyes_cm + 0.1f * body_.head_cm &&
                        body_.beside_axis_cm(c) < 0.33f * body_.head_cm;
  const float above_eyes = head * ramp(-0.1f, 0.2f, (c.y - body_.eyes_cm) / body_.head_cm);
  const float foot = body_.is_whole ? 1 - ramp(0.035f, 0.06f, body_.share_of(c.y)) : 0;
  return {1,
          skin,
          skin * head,
          hair,
          hair * head,
          in_hair_[f] * head,
          in_hair_[f] * (1 - head),
          head,
          static_cast<float>(is_front),
          above_eyes,
          foot,
          std::log(1 + features_.local_spread[f].x) / 3,
          near_by(kFar * skin),
          near_by(kFar * hair)};
}

StartCues CueFinder::run() {
  sample_parts();
  flood_hair();
  StartCues start;
  start.frame = body_;
  start.found_face = skin_.area_cm2 > 0;
  start.cues.resize(graph_.size());
  for (uint32_t f = 0; f < graph_.size(); ++f) start.cues[f] = cues_of(f);
  return start;
}

}  // namespace

BodyFrame body_frame(const FaceFeatures& features) {
  const FaceGraph& graph = features.graph;
  BodyFrame frame;
  Vec3f low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
  for (const Vec3f& c : graph.centre_cm)
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], c[i]);
      high[i] = std::max(high[i], c[i]);
    }
  const float height = high.y - low.y;
  frame.ground_cm = low.y;
  frame.top_cm = high.y;
  frame.is_whole = height > 3 * (high.z - low.z) || height > 110;
  frame.chin_cm = frame.is_whole ? low.y + 0.868f * height : high.y - std::min(23.0f, 0.7f * height);
  frame.eyes_cm = frame.is_whole ? low.y + 0.932f * height : high.y - std::min(12.0f, 0.4f * height);
  frame.head_cm = frame.top_cm - frame.chin_cm;
  std::vector<std::pair<float, float>> x, z;
  for (size_t f = 0; f < graph.size(); ++f)
    if (graph.centre_cm[f].y > frame.eyes_cm) {
      x.emplace_back(graph.centre_cm[f].x, graph.area_cm2[f]);
      z.emplace_back(graph.centre_cm[f].z, graph.area_cm2[f]);
    }
  frame.head_x_cm = weighted_quantile(x);
  frame.head_z_cm = weighted_quantile(z);
  find_front(features, frame);
  return frame;
}

bool is_face_front(const FaceGraph& graph, const BodyFrame& frame, uint32_t face) {
  const Vec3f c = graph.centre_cm[face];
  return c.y > frame.chin_cm && c.y < frame.eyes_cm && frame.beside_axis_cm(c) < 0.25f * frame.head_cm &&
         frame.before_axis_cm(c) > 0 && dot(graph.normal[face], frame.front) > 0.3f;
}

StartCues start_cues(const FaceFeatures& features) {
  return CueFinder(features).run();
}

}  // namespace ohb::labelling
