#include "dataset/labelling/start_labels.h"

#include <algorithm>
#include <cmath>

namespace ohb {
namespace {

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

float hue_degrees(Vec3f lab) {
  return std::atan2(lab.z, lab.y) * 57.29578f;
}
float chroma(Vec3f lab) {
  return std::hypot(lab.y, lab.z);
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

class Starter {
 public:
  explicit Starter(const FaceFeatures& features)
      : features_(features), graph_(features.graph), body_(body_frame(features.graph)) {}

  StartLabels run();

 private:
  bool is_face_front(uint32_t f) const {
    const Vec3f c = graph_.centre_cm[f];
    return c.y > body_.chin_cm && c.y < body_.eyes_cm &&
           std::abs(c.x - body_.head_x_cm) < 0.25f * body_.head_cm && c.z > body_.head_z_cm &&
           graph_.normal[f].z > 0.3f;
  }
  bool is_in_head(uint32_t f) const {
    const Vec3f c = graph_.centre_cm[f];
    return c.y > body_.chin_cm - 0.1f * body_.head_cm &&
           std::hypot(c.x - body_.head_x_cm, c.z - body_.head_z_cm) < 0.8f * body_.head_cm;
  }
  void sample_parts();
  void measure_skin();
  void flood_hair();
  ClassValues head_scores(uint32_t f) const;
  ClassValues body_scores(uint32_t f) const;

  const FaceFeatures& features_;
  const FaceGraph& graph_;
  const BodyFrame body_;
  ColourSample skin_, hair_, torso_, shoe_;
  float shoe_leather_ = 0.65f;
  std::vector<float> skin_likeness_, hair_likeness_;
  std::vector<bool> in_hair_;
};

void Starter::sample_parts() {
  skin_ = sample_colour(features_,
                        [&](uint32_t f) { return is_face_front(f) && is_skin_locus(features_.lab[f]); });
  measure_skin();
  const float crown = body_.eyes_cm + 0.35f * (body_.top_cm - body_.eyes_cm);
  ColourSample bare = sample_colour(features_, [&](uint32_t f) {
    return graph_.centre_cm[f].y > crown && is_in_head(f) && skin_likeness_[f] > 0.5f;
  });
  hair_ = sample_colour(features_, [&](uint32_t f) {
    return graph_.centre_cm[f].y > crown && is_in_head(f) && skin_likeness_[f] < 0.5f;
  });
  if (hair_.area_cm2 < 0.3f * bare.area_cm2 || !is_hair_locus(hair_.lab)) hair_.area_cm2 = 0;
  if (!body_.is_whole) return;
  const float height = body_.top_cm - body_.ground_cm;
  torso_ = sample_colour(features_, [&](uint32_t f) {
    const float share = (graph_.centre_cm[f].y - body_.ground_cm) / height;
    return share > 0.55f && share < 0.8f && skin_likeness_[f] < 0.5f &&
           std::abs(graph_.centre_cm[f].x - body_.head_x_cm) < 0.12f * height && graph_.normal[f].z > 0;
  });
  double white = 0, vivid = 0, total = 0;
  for (uint32_t f = 0; f < graph_.size(); ++f) {
    if (graph_.centre_cm[f].y > body_.ground_cm + 0.04f * height) continue;
    const Vec3f lab = features_.lab[f];
    const float area = graph_.area_cm2[f], hue = hue_degrees(lab);
    total += area;
    if (lab.x > 65 && chroma(lab) < 15) white += area;
    if (chroma(lab) > 12 && (hue < 0 || hue > 100)) vivid += area;
  }
  // Trainers: white soles, blue, green or purple; all else on feet is likelier leather.
  if (white > 0.12 * total || vivid > 0.3 * total) shoe_leather_ = 0.25f;
}

void Starter::measure_skin() {
  skin_likeness_.assign(graph_.size(), 0);
  if (!(skin_.area_cm2 > 0)) return;
  for (uint32_t f = 0; f < graph_.size(); ++f) {
    const float d = distance(features_.lab[f], skin_, 15, 5.5f);
    skin_likeness_[f] = 1 / (1 + std::exp(3 * (d - 2.3f)));
  }
}

/// Hair that hangs down from the head: faces of its colour that hair-coloured faces connect with the crown.
void Starter::flood_hair() {
  hair_likeness_.assign(graph_.size(), 0);
  in_hair_.assign(graph_.size(), false);
  if (!(hair_.area_cm2 > 0)) return;
  std::vector<uint32_t> front;
  for (uint32_t f = 0; f < graph_.size(); ++f) {
    float d = distance(features_.lab[f], hair_, 14, 7);
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
      if (is_below && body_.is_whole && distance(features_.lab[f], torso_, 10, 5) < 2) continue;
      if (is_below && std::hypot(graph_.centre_cm[f].x - body_.head_x_cm,
                                 graph_.centre_cm[f].z - body_.head_z_cm) > 1.2f * body_.head_cm)
        continue;
      if (length(features_.lab[f] - features_.lab[front[i]]) > 15) continue;
      in_hair_[f] = true;
      front.push_back(f);
    }
}

/// Skin, hair, fabric, leather on the head.
ClassValues Starter::head_scores(uint32_t f) const {
  const Vec3f c = graph_.centre_cm[f];
  const float skin = skin_likeness_[f];
  const bool is_front = c.z > body_.head_z_cm && graph_.normal[f].z > 0 &&
                        std::abs(c.x - body_.head_x_cm) < 0.33f * body_.head_cm;
  const float above_eyes = ramp(-0.1f, 0.2f, (c.y - body_.eyes_cm) / body_.head_cm);
  ClassValues p;
  if (in_hair_[f]) {
    p = {0.15f, 0.8f, 0.04f, 0.01f};
    if (is_front && c.y < body_.eyes_cm + 0.1f * body_.head_cm) p = {0.45f, 0.5f, 0.04f, 0.01f};
  } else if (is_front && c.y > body_.chin_cm && c.y < body_.eyes_cm + 0.1f * body_.head_cm) {
    p = {0.8f, 0.12f, 0.07f, 0.01f};  // eyes, lips, brows
  } else {
    const float hair = hair_.area_cm2 > 0 ? 0.3f + 0.5f * above_eyes : 0.1f;
    p = {0.15f, hair, 0.75f - hair, 0.1f};
    if (c.y < body_.chin_cm + 0.2f * body_.head_cm) p = {0.15f, 0.1f + 0.3f * hair_likeness_[f], 0.65f, 0.1f};
  }
  for (int k = 0; k < kClassCount; ++k) p[k] = (1 - skin) * p[k] + skin * (k == kSkin ? 0.93f : 0.03f);
  return p;
}

ClassValues Starter::body_scores(uint32_t f) const {
  const Vec3f lab = features_.lab[f], c = graph_.centre_cm[f];
  const float skin = skin_likeness_[f], hue = hue_degrees(features_.local_lab[f]);
  const float share = (c.y - body_.ground_cm) / (body_.top_cm - body_.ground_cm);
  ClassValues p = {0.06f, 0.04f, 0.8f, 0.1f};
  if (in_hair_[f]) p = {0.05f, 0.65f, 0.25f, 0.05f};
  // Dark brown garments are leather more often than not.
  const Vec3f local = features_.local_lab[f];
  if (!in_hair_[f] && local.x < 32 && hue > 40 && hue < 75 && chroma(local) > 8 && chroma(local) < 30 &&
      features_.local_spread[f].x < 8)
    p = {0.05f, 0.05f, 0.35f, 0.55f};
  if (body_.is_whole) {
    const float foot = 1 - ramp(0.035f, 0.06f, share);
    const ClassValues shoe = {0.05f, 0, 0.95f - shoe_leather_, shoe_leather_};
    for (int k = 0; k < kClassCount; ++k) p[k] = (1 - foot) * p[k] + foot * shoe[k];
  }
  (void)lab;
  for (int k = 0; k < kClassCount; ++k) p[k] = (1 - skin) * p[k] + skin * (k == kSkin ? 0.88f : 0.04f);
  return p;
}

StartLabels Starter::run() {
  sample_parts();
  flood_hair();
  StartLabels start;
  start.frame = body_;
  start.found_face = skin_.area_cm2 > 0;
  start.probability.resize(graph_.size());
  start.trust.resize(graph_.size());
  for (uint32_t f = 0; f < graph_.size(); ++f) {
    ClassValues p = is_in_head(f) ? head_scores(f) : body_scores(f);
    float sum = 0;
    for (float& v : p) sum += v = std::max(v, 0.01f);
    float entropy = 0;
    for (float& v : p) {
      v /= sum;
      entropy -= v * std::log(v);
    }
    start.probability[f] = p;
    start.trust[f] = 1 - entropy / std::log(static_cast<float>(kClassCount));
  }
  return start;
}

}  // namespace

BodyFrame body_frame(const FaceGraph& graph) {
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
  return frame;
}

StartLabels start_labels(const FaceFeatures& features) {
  return Starter(features).run();
}

}  // namespace ohb
