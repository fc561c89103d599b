#include "dataset/labelling/garments.h"

#include <algorithm>
#include <map>

#include "dataset/labelling/region_merging.h"

namespace ohb::labelling {
namespace {

const Appearance kLookWidth(12, 6, 6, 0.6f);
constexpr float kShoe_share = 0.04f;   // of the height: what lies lower is a part of the shoe
constexpr float kSmall_share = 0.06f;  // of the whole area
constexpr float kCrumb_share = 0.01f;  // of the whole area

/// Where on the body: garments of different places are asked about one by one.
enum class Place { kFeet, kLegs, kUpper, kHead };

struct Part {
  std::vector<uint32_t> faces;
  float area_cm2 = 0, height = 0, low = 1, high = 0;  // heights: shares of the person's
  Appearance look = Appearance::Zero();
  uint8_t part = kFabric;
  bool is_on_head = false;  // and not reaching below it
};

Place place_of(const Part& part, const BodyFrame& frame) {
  if (!frame.is_whole) return Place::kUpper;
  if (part.height < 0.06f) return Place::kFeet;
  if (part.height < 0.5f) return Place::kLegs;
  return part.height < 0.86f ? Place::kUpper : Place::kHead;
}

std::string name_of(const Part& part, const BodyFrame& frame) {
  switch (place_of(part, frame)) {
    case Place::kFeet:
      return "shoes";
    case Place::kHead:
      return part.part == kFabric ? "headwear" : "head";
    case Place::kLegs:
      if (part.high < 0.3f) return "socks";
      if (part.high > 0.7f) return "dress";
      return part.low < 0.2f ? "trousers" : "skirt";
    default:
      break;
  }
  if (!frame.is_whole) return "garment";
  if (part.low < 0.3f) return "dress";
  return part.high - part.low < 0.1f && part.height < 0.65f ? "belt" : "top";
}

void measure(const FaceFeatures& features, const BodyFrame& frame, Part& part) {
  std::vector<std::pair<float, float>> heights;
  for (uint32_t f : part.faces) {
    const float area = features.graph.area_cm2[f] + 1e-6f, y = frame.share_of(features.graph.centre_cm[f].y);
    part.area_cm2 += area;
    part.height += area * y;
    part.look += area * features.appearance[f];
    heights.emplace_back(y, area);
  }
  part.height /= part.area_cm2;
  part.look /= part.area_cm2;
  std::sort(heights.begin(), heights.end());
  float sum = 0;  // the outermost twentieths may be crumbs of others
  for (const auto& [y, area] : heights) {
    sum += area;
    if (sum < 0.05f * part.area_cm2) part.low = y;
    if (sum < 0.95f * part.area_cm2) part.high = y;
  }
  if (part.low > part.high) part.low = heights.front().first;
}

Appearance look_around(const FaceFeatures& features, size_t f) {
  const Vec3f lab = features.local_lab[f];
  return Appearance(lab.x, lab.y, lab.z, features.appearance[f][3]);
}

/// Skin and hair of the head are apart from what lies below.
bool is_below_head(Vec3f at, uint8_t part, const BodyFrame& frame) {
  constexpr float kNeck_heads = 0.15f;
  return at.y < frame.chin_cm - (part == kSkin ? kNeck_heads * frame.head_cm : 0);
}

/// Skin that holds a part of the face is no headwear.
bool holds_face(const FaceFeatures& features, const BodyFrame& frame, const std::vector<uint8_t>& part,
                const std::vector<uint32_t>& faces) {
  constexpr float kOfFace = 0.1f;  // of the face's skin
  float all = 0, own = 0;
  for (uint32_t f = 0; f < features.size(); ++f)
    if (part[f] == kSkin && is_face_front(features.graph, frame, f)) all += features.graph.area_cm2[f];
  for (uint32_t f : faces)
    if (is_face_front(features.graph, frame, f)) own += features.graph.area_cm2[f];
  return own > kOfFace * all;
}

/// Of clothes all over the body; of skin and hair on the head, or below it.
std::vector<Part> connected_parts(const FaceFeatures& features, const std::vector<float>& likeness,
                                  const BodyFrame& frame, const std::vector<uint8_t>& part,
                                  std::pair<uint8_t, bool> own_and_head) {
  const auto [own, is_on_head] = own_and_head;
  std::vector<bool> is_in;
  for (size_t f = 0; f < part.size(); ++f)
    is_in.push_back(part[f] == own &&
                    (own == kFabric || (frame.is_whole && is_below_head(features.graph.centre_cm[f], own,
                                                                        frame) != is_on_head)));
  std::vector<Appearance> look(features.size());
  float area = 0;
  for (size_t f = 0; f < look.size(); ++f) {
    look[f] = look_around(features, f);
    area += features.graph.area_cm2[f];
  }
  RegionMerging regions(features.graph, likeness, is_in, look);
  regions.merge_below(own == kFabric ? kSeparate_cm : kSeparateSkin_cm);
  regions.merge_crumbs(kCrumb_share * area);
  std::map<uint32_t, Part> parts;
  for (uint32_t f = 0; f < features.size(); ++f)
    if (is_in[f]) parts[regions.region_of(f)].faces.push_back(f);
  std::vector<Part> all;
  for (auto& [region, of] : parts) {
    measure(features, frame, of);
    of.part = own;
    of.is_on_head = own == kFabric ? place_of(of, frame) == Place::kHead : is_on_head;
    const bool is_face = own == kSkin && is_on_head && holds_face(features, frame, part, of.faces);
    if (own == kFabric || (of.area_cm2 > kCrumb_share * area && !is_face)) all.push_back(std::move(of));
  }
  return all;
}

/// Faces of small garments that look like a large one, and not like their own, are crumbs of it.
void give_to_look_alikes(const FaceFeatures& features, Garments& found) {
  for (size_t f = 0; f < features.size(); ++f) {
    const uint32_t own = found.of_face[f];
    if (own == Garments::kNone || found.garments[own].part != kFabric ||
        found.garments[own].area_cm2 > kSmall_share * found.all_cm2)
      continue;
    const Appearance look = look_around(features, f);
    float nearest = std::min(1.0f, 0.5f * look_difference(look, found.garments[own].look));
    for (uint32_t g = 0; g < found.garments.size(); ++g) {
      if (!(found.garments[g].area_cm2 > kSmall_share * found.all_cm2) || found.garments[own].is_shoe ||
          found.garments[g].part != kFabric)
        continue;
      const float difference = look_difference(look, found.garments[g].look);
      if (difference >= nearest) continue;
      nearest = difference;
      found.of_face[f] = g;
    }
  }
}

/// Index of the garment that each part belongs to: the first (largest) one at its place that looks like it.
std::vector<size_t> join_parts(const std::vector<Part>& parts, const BodyFrame& frame) {
  std::vector<size_t> joined(parts.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    joined[i] = i;
    for (size_t j = 0; j < i && joined[i] == i; ++j) {
      const Place place = place_of(parts[i], frame);
      if (joined[j] == j && parts[i].part == parts[j].part && parts[i].is_on_head == parts[j].is_on_head &&
          place == place_of(parts[j], frame) &&
          (parts[i].height < kShoe_share || look_difference(parts[i].look, parts[j].look) < kAlike))
        joined[i] = j;
    }
  }
  return joined;
}

}  // namespace

float look_difference(const Appearance& l, const Appearance& r) {
  return (l - r).cwiseQuotient(kLookWidth).squaredNorm();
}

uint32_t middle_of(const FaceGraph& graph, const std::vector<uint32_t>& faces) {
  std::vector<uint8_t> state(graph.size(), 0);  // 0 outside, 1 inside, 2 reached
  for (uint32_t f : faces) state[f] = 1;
  std::vector<uint32_t> reached;
  for (uint32_t f : faces)
    for (uint32_t n = graph.first_neighbour[f]; n < graph.first_neighbour[f + 1] && state[f] == 1; ++n)
      if (state[graph.neighbours[n].face] == 0) {
        state[f] = 2;
        reached.push_back(f);
      }
  for (size_t i = 0; i < reached.size(); ++i)
    for (uint32_t n = graph.first_neighbour[reached[i]]; n < graph.first_neighbour[reached[i] + 1]; ++n) {
      const uint32_t to = graph.neighbours[n].face;
      if (state[to] != 1) continue;
      state[to] = 2;
      reached.push_back(to);
    }
  return reached.empty() ? faces.front() : reached.back();
}

Garments find_garments(const FaceFeatures& features, const std::vector<float>& likeness,
                       const BodyFrame& frame, const std::vector<uint8_t>& part) {
  std::vector<Part> parts;
  for (std::pair<uint8_t, bool> own : {std::pair<uint8_t, bool>(kSkin, false),
                                       {kHair, false},
                                       {kFabric, false},
                                       {kSkin, true},
                                       {kHair, true}})
    for (Part& of : connected_parts(features, likeness, frame, part, own)) parts.push_back(std::move(of));
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& l, const Part& r) { return l.area_cm2 > r.area_cm2; });
  const std::vector<size_t> joined = join_parts(parts, frame);
  std::vector<Part> whole(parts.size());
  for (size_t i = 0; i < parts.size(); ++i)
    whole[joined[i]].faces.insert(whole[joined[i]].faces.end(), parts[i].faces.begin(), parts[i].faces.end());
  std::vector<size_t> order;
  for (size_t i = 0; i < whole.size(); ++i)
    if (!whole[i].faces.empty()) {
      measure(features, frame, whole[i]);
      whole[i].part = parts[i].part;
      whole[i].is_on_head = parts[i].is_on_head;
      order.push_back(i);
    }
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t l, size_t r) { return whole[l].area_cm2 > whole[r].area_cm2; });
  Garments found;
  found.of_face.assign(features.size(), Garments::kNone);
  for (float area : features.graph.area_cm2) found.all_cm2 += area;
  std::map<std::string, int> named;
  for (size_t i : order) {
    Garment garment;
    garment.name = name_of(whole[i], frame);
    const int count = ++named[garment.name];
    if (count > 1) garment.name += "-" + std::to_string(count);
    garment.area_cm2 = whole[i].area_cm2;
    garment.look = whole[i].look;
    garment.part = whole[i].part;
    garment.is_on_head = whole[i].is_on_head;
    garment.is_shoe = place_of(whole[i], frame) == Place::kFeet;
    garment.face = middle_of(features.graph, parts[i].faces);
    for (uint32_t f : whole[i].faces) found.of_face[f] = static_cast<uint32_t>(found.garments.size());
    found.garments.push_back(garment);
  }
  give_to_look_alikes(features, found);
  for (size_t f = 0; f < features.size(); ++f)
    if (found.of_face[f] != Garments::kNone) {
      Garment& of = found.garments[found.of_face[f]];
      of.variation +=
          features.graph.area_cm2[f] / of.area_cm2 * look_difference(features.appearance[f], of.look);
    }
  return found;
}

}  // namespace ohb::labelling
