#include "dataset/people/body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/model/error.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

struct Share {
  const char* name;
  float weight;
};
using Shares = std::vector<Share>;

/// Low, middle and high of a slider.
Shares three(float slider, const char* low, const char* middle, const char* high) {
  const float below = std::max(0.0f, 1 - 2 * slider), above = std::max(0.0f, 2 * slider - 1);
  return {{low, below}, {middle, 1 - below - above}, {high, above}};
}

/// 10 years is a child, 25 young, 90 old; in between they mix (MakeHuman's age slider a = (years - 1) / 48 up
/// to 25 years).
Shares age_shares(float years) {
  if (years <= 25) {
    const float young = std::clamp(3.2f * ((years - 1) / 48 - 0.1875f), 0.0f, 1.0f);
    return {{"child", 1 - young}, {"young", young}};
  }
  const float old = std::clamp((years - 25) / 65, 0.0f, 1.0f);
  return {{"young", 1 - old}, {"old", old}};
}

/// Walks through the products of several lists of shares.
template <typename Use>
void for_products(const std::vector<const Shares*>& lists, const Use& use, size_t depth = 0,
                  const std::string& name = "", float weight = 1) {
  if (depth == lists.size()) {
    use(name, weight);
    return;
  }
  for (const Share& share : *lists[depth])
    if (share.weight > 0)
      for_products(lists, use, depth + 1, name.empty() ? share.name : name + "-" + share.name,
                   weight * share.weight);
}

}  // namespace

BaseMesh read_base_mesh(const fs::path& file) {
  BaseMesh base;
  base.mesh = read_scan(file);
  const auto group = [&](const char* name) {
    const auto& groups = base.mesh.groups;
    const auto found = std::find(groups.begin(), groups.end(), name);
    if (found == groups.end())
      throw InputError(file.string(), "", std::string("there is no group '") + name + "'",
                       "take MakeHuman's own base.obj");
    return static_cast<uint16_t>(found - groups.begin());
  };
  const uint16_t skin = group("body"), ground = group("joint-ground");
  for (uint32_t face = 0; face < base.mesh.face_count(); ++face) {
    const bool is_skin = base.mesh.face_group[face] == skin;
    if (is_skin) base.skin_faces.push_back(face);
    for (uint32_t c = base.mesh.face_begin[face]; c < base.mesh.face_begin[face + 1]; ++c) {
      if (is_skin && base.mesh.corners[c].uv == Corner::kNoUv)
        throw InputError(file.string(), fmt::format("face {}", face + 1), "has no UVs",
                         "take MakeHuman's own base.obj");
      if (base.mesh.face_group[face] == ground) base.ground_vertices.push_back(base.mesh.corners[c].position);
    }
  }
  return base;
}

std::vector<WeightedTarget> macro_targets(const BodySliders& s) {
  const Shares races = {{"african", s.african}, {"asian", s.asian}, {"caucasian", s.caucasian}};
  const Shares genders = {{"female", 1 - s.male}, {"male", s.male}};
  const Shares ages = age_shares(s.years);
  const Shares muscles = three(s.muscle, "minmuscle", "averagemuscle", "maxmuscle");
  const Shares weights = three(s.weight, "minweight", "averageweight", "maxweight");
  const Shares heights = three(s.height, "minheight", "", "maxheight");
  const Shares proportions = three(s.proportions, "uncommonproportions", "", "idealproportions");
  const Shares cups = three(s.cup, "mincup", "averagecup", "maxcup");
  const Shares firmnesses = three(s.firmness, "minfirmness", "averagefirmness", "maxfirmness");
  std::vector<WeightedTarget> targets;
  const auto add = [&](const std::string& folder, const std::vector<const Shares*>& lists) {
    for_products(lists, [&](const std::string& name, float weight) {
      if (name.back() != '-') targets.emplace_back(folder + name, weight);
    });
  };
  add("macrodetails/", {&races, &genders, &ages});
  const Shares universal = {{"universal", 1}};
  add("macrodetails/", {&universal, &genders, &ages, &muscles, &weights});
  add("macrodetails/height/", {&genders, &ages, &muscles, &weights, &heights});
  add("macrodetails/proportions/", {&genders, &ages, &muscles, &weights, &proportions});
  add("breast/", {&genders, &ages, &muscles, &weights, &cups, &firmnesses});
  return targets;
}

std::vector<Vec3f> morphed(const BaseMesh& base, const MorphTargets& library,
                           const std::vector<WeightedTarget>& targets) {
  std::vector<Vec3f> positions = base.mesh.positions;
  for (const auto& [name, weight] : targets) {
    const auto target = library.find(name);
    if (!target) continue;
    for (size_t i = 0; i < target->vertices.size(); ++i)
      positions[target->vertices[i]] += weight * target->moves_dm[i];
  }
  return positions;
}

float height_of(const BaseMesh& base, const std::vector<Vec3f>& positions) {
  float low = INFINITY, high = -INFINITY;
  for (const uint32_t face : base.skin_faces)
    for (uint32_t c = base.mesh.face_begin[face]; c < base.mesh.face_begin[face + 1]; ++c) {
      const float y = positions[base.mesh.corners[c].position].y;
      low = std::min(low, y), high = std::max(high, y);
    }
  return high - low;
}

}  // namespace ohb::people
