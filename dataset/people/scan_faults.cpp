#include "dataset/people/scan_faults.h"

#include <algorithm>
#include <cmath>

#include "dataset/model/noise.h"
#include "dataset/people/random.h"
#include "dataset/people/visible_faces.h"

namespace ohb::people {
namespace {

Random random_of(const Person& person, const char* purpose) {
  return Random(split_mix(person.recipe->seed) + static_cast<uint64_t>(person.recipe->index), purpose);
}

Vec3f middle_of(const Part& part, uint32_t face) {
  const uint32_t begin = part.mesh->face_begin[face], end = part.mesh->face_begin[face + 1];
  Vec3f sum;
  for (uint32_t c = begin; c < end; ++c) sum += part.posed_cm[part.mesh->corners[c].position];
  return sum / static_cast<float>(end - begin);
}

}  // namespace

void add_noise(Person& person, float deviation_cm) {
  Random random = random_of(person, "noise");
  constexpr float kSmooth_cm = 3;
  // Value noise has a standard deviation of about a sixth.
  constexpr float kOfValueNoise = 6;
  const float share = deviation_cm * std::sqrt(.5f);
  for (Part& part : person.parts) {
    if (part.kind == PartKind::kBrows) continue;
    const std::vector<Vec3f> normals = normals_of(part, part.posed_cm);
    for (size_t v = 0; v < normals.size(); ++v) {
      const float smooth_part = kOfValueNoise * (value_noise(part.posed_cm[v] / kSmooth_cm, 11) - .5f);
      part.posed_cm[v] += share * (random.normal() + smooth_part) * normals[v];
    }
  }
}

void cut_holes(Person& person, int count) {
  Random random = random_of(person, "holes");
  for (int i = 0; i < count; ++i) {
    size_t all = 0;
    for (const Part& part : person.parts)
      if (part.kind != PartKind::kBrows) all += part.faces.size();
    if (all == 0) return;
    size_t which = random.below(all);
    Vec3f at;
    for (const Part& part : person.parts) {
      if (part.kind == PartKind::kBrows) continue;
      if (which < part.faces.size()) {
        at = middle_of(part, part.faces[which]);
        break;
      }
      which -= part.faces.size();
    }
    const float radius_cm = random.within(1, 4);
    for (Part& part : person.parts) {
      const auto is_lost = [&](uint32_t face) { return length(middle_of(part, face) - at) < radius_cm; };
      size_t kept = 0;
      for (const Part& other : person.parts) kept += other.faces.size();
      const auto end = std::remove_if(part.faces.begin(), part.faces.end(), is_lost);
      const auto lost = static_cast<size_t>(part.faces.end() - end);
      if (lost < kept) part.faces.erase(end, part.faces.end());
    }
  }
}

std::vector<std::vector<float>> soft_shading(const Person& person) {
  const SurfaceQuery all = surface_of(person);
  constexpr int kWays = 96;
  constexpr float kFar_cm = 500, kStart_cm = .1f;
  std::vector<Vec3f> ways;
  std::vector<float> light;
  for (int i = 0; i < kWays; ++i) {
    const double y = 1 - (2.0 * i + 1) / kWays, radius = std::sqrt(1 - y * y), turn = 2.399963229728653 * i;
    ways.push_back({static_cast<float>(radius * std::cos(turn)), static_cast<float>(y),
                    static_cast<float>(radius * std::sin(turn))});
    light.push_back(std::max(.05f, .55f + .35f * ways.back().y + .3f * ways.back().z));
  }
  std::vector<std::vector<float>> shades;
  for (const Part& part : person.parts) {
    const std::vector<Vec3f> normals = normals_of(part, part.posed_cm);
    std::vector<float>& shade = shades.emplace_back(normals.size(), 1.0f);
    if (part.kind == PartKind::kBrows) continue;
    for (size_t v = 0; v < normals.size(); ++v) {
      float sum = 0, open = 0;
      for (size_t w = 0; w < ways.size(); ++w) {
        const float cosine = dot(ways[w], normals[v]);
        if (cosine <= .02f) continue;
        open += cosine;
        if (!all.is_blocked(part.posed_cm[v] + kStart_cm * normals[v], ways[w], kFar_cm))
          sum += cosine * light[w];
      }
      shade[v] = open > 0 ? sum / open : 1;
    }
  }
  return shades;
}

}  // namespace ohb::people
