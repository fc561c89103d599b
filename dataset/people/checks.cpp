#include "dataset/people/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "dataset/model/mesh_topology.h"

namespace ohb::people {
namespace {

constexpr float kDeepestPoke_cm = 1.2f, kLargestPoke_cm2 = 12;
constexpr float kDeepestLimb_cm = 1.8f;
constexpr int kMostLimbVertices = 25;
constexpr float kLargestHairGap_cm = 3;

enum Limb : uint8_t { kCore, kLeftArm, kRightArm, kLeftLeg, kRightLeg, kBorder };

/// Which limb each bone belongs to; shoulders and hips are borders, which count for nothing.
std::vector<Limb> limbs_of_bones(const Skeleton& skeleton) {
  std::vector<Limb> limbs(skeleton.bones.size(), kCore);
  for (size_t i = 0; i < limbs.size(); ++i) {
    const Bone& bone = skeleton.bones[i];
    const bool is_left = bone.name.size() > 2 && bone.name.substr(bone.name.size() - 2) == ".L";
    const auto starts = [&](const char* with) { return bone.name.rfind(with, 0) == 0; };
    if (starts("upperarm01") || starts("shoulder01") || starts("clavicle") || starts("upperleg01") ||
        starts("pelvis"))
      limbs[i] = kBorder;
    else if (starts("upperarm02") || starts("lowerarm01"))
      limbs[i] = is_left ? kLeftArm : kRightArm;
    else if (starts("upperleg02") || starts("lowerleg01"))
      limbs[i] = is_left ? kLeftLeg : kRightLeg;
    else if (bone.parent >= 0)
      limbs[i] = limbs[static_cast<size_t>(bone.parent)];
    if (limbs[i] == kBorder && bone.parent >= 0 && starts("spine")) limbs[i] = kCore;
  }
  return limbs;
}

/// The limb of each vertex of a part: that of nine tenths of its weight, else a border.
std::vector<Limb> limbs_of(const Part& part, const std::vector<Limb>& of_bones) {
  std::vector<Limb> limbs;
  for (const VertexBones& bones : part.bones) {
    float share[6] = {};
    for (const BoneShare& bone : bones) share[of_bones[bone.bone]] += bone.weight;
    const auto most = static_cast<Limb>(std::max_element(share, share + 6) - share);
    limbs.push_back(share[most] > .9f ? most : kBorder);
  }
  return limbs;
}

/// Skin and clothes as one surface, with the limb of each triangle.
struct Dressed {
  std::vector<Vec3f> positions;
  std::vector<SurfaceTriangle> triangles;
  std::vector<Limb> limb_of_vertex, limb_of_triangle;

  Dressed(const Assets& assets, const Person& person) {
    const std::vector<Limb> of_bones = limbs_of_bones(assets.skeleton());
    for (const Part& part : person.parts) {
      if (part.kind != PartKind::kSkin && part.kind != PartKind::kClothes) continue;
      const auto first = static_cast<uint32_t>(positions.size());
      const std::vector<Limb> limbs = limbs_of(part, of_bones);
      std::vector<char> is_used(limbs.size(), 0);
      positions.insert(positions.end(), part.posed_cm.begin(), part.posed_cm.end());
      for (SurfaceTriangle triangle : triangles_of(part)) {
        const Limb limb = limbs[triangle.corner[0]];
        bool same = true;
        for (uint32_t& corner : triangle.corner)
          same = same && limbs[corner] == limb, is_used[corner] = 1, corner += first;
        limb_of_triangle.push_back(same ? limb : kBorder);
        triangles.push_back(triangle);
      }
      for (size_t v = 0; v < limbs.size(); ++v) limb_of_vertex.push_back(is_used[v] ? limbs[v] : kBorder);
    }
  }
};

void find_limbs(const Assets& assets, const Person& person, PersonFaults& faults) {
  const Dressed dressed(assets, person);
  const SurfaceQuery surface(dressed.positions, dressed.triangles);
  constexpr float kReach_cm = 6, kCounts_cm = 1;
  for (size_t v = 0; v < dressed.positions.size(); ++v) {
    const Limb limb = dressed.limb_of_vertex[v];
    if (limb == kCore || limb == kBorder) continue;
    const SurfaceHit near = surface.nearest(dressed.positions[v], kReach_cm, [&](uint32_t triangle) {
      const Limb other = dressed.limb_of_triangle[triangle];
      return other != limb && other != kBorder;
    });
    if (!near.found || near.distance_cm < kCounts_cm) continue;
    const Vec3f away = normalised(dressed.positions[v] - surface.at(near));
    if (dot(away, near.normal) > -.8f) continue;  // beside an edge, or outside
    ++faults.limb_vertices;
    faults.limb_depth_cm = std::max(faults.limb_depth_cm, near.distance_cm);
  }
}

void find_hair_gaps(const Person& person, PersonFaults& faults) {
  const SurfaceQuery skin(person.skin().posed_cm, triangles_of(person.skin()));
  for (const Part& hair : person.parts) {
    if (hair.kind != PartKind::kHair) continue;
    DisjointSets locks(hair.posed_cm.size());
    for (const SurfaceTriangle& triangle : triangles_of(hair))
      locks.join(triangle.corner[0], triangle.corner[1]), locks.join(triangle.corner[0], triangle.corner[2]);
    constexpr float kReach_cm = 30;
    std::map<uint32_t, float> gap;
    for (const SurfaceTriangle& triangle : triangles_of(hair))
      for (const uint32_t corner : triangle.corner) {
        float& least = gap.emplace(locks.find(corner), kReach_cm).first->second;
        const SurfaceHit near = skin.nearest(hair.posed_cm[corner], least);
        if (near.found) least = std::min(least, near.distance_cm);
      }
    for (const auto& [lock, distance] : gap) faults.hair_gap_cm = std::max(faults.hair_gap_cm, distance);
  }
}

}  // namespace

PersonFaults find_faults(const Assets& assets, const Person& person) {
  PersonFaults faults;
  faults.pokes = find_pokes(person);
  find_limbs(assets, person, faults);
  find_hair_gaps(person, faults);
  return faults;
}

std::string PersonFaults::verdict() const {
  if (pokes.depth_cm > kDeepestPoke_cm || pokes.area_cm2 > kLargestPoke_cm2)
    return fmt::format("{}: {:.1f} cm deep, {:.0f} cm2", pokes.worst, pokes.depth_cm, pokes.area_cm2);
  if (limb_depth_cm > kDeepestLimb_cm && limb_vertices > kMostLimbVertices)
    return fmt::format("a limb lies {:.1f} cm deep in another part ({} vertices)", limb_depth_cm,
                       limb_vertices);
  if (hair_gap_cm > kLargestHairGap_cm) return fmt::format("hair floats {:.1f} cm off", hair_gap_cm);
  return "";
}

}  // namespace ohb::people
