#include "dataset/people/layers.h"

#include <algorithm>
#include <cmath>

namespace ohb::people {
namespace {

/// How far under the cloth skin and inner cloth lie.
constexpr float kGap_cm = 0.25f;
/// How far an inner layer may be outside an outer one and still be pressed in; hair stands far out of hats.
constexpr float kDeepest_cm = 2.5f, kHairUnderHat_cm = 6;
/// Cloth within this distance along the normal, in the rest pose, lies over the vertex.
constexpr float kCovers_cm = 3.5f, kHides_cm = 9;

SurfaceQuery query_of(const Part& part, const std::vector<Vec3f>& positions) {
  return SurfaceQuery(positions, triangles_of(part));
}

/// An outer layer, at rest and in the pose.
struct Outer {
  const Part* part;
  SurfaceQuery rest, posed;
  explicit Outer(const Part& p) : part(&p), rest(query_of(p, p.rest_cm)), posed(query_of(p, p.posed_cm)) {}
  /// Skin under a brim must not be looked for as far as hair is: brows and eye sockets would be pressed into
  /// the head.
  float deepest_cm(const Part& inner) const {
    const bool is_hat = part->worn && part->worn->slot == Slot::kHat;
    return is_hat && inner.kind == PartKind::kHair ? kHairUnderHat_cm : kDeepest_cm;
  }
};

/// Distance from a point to the cloth along the normal, negative where the point is outside; infinite where
/// there is none within reach. Cloth that faces the other way does not count.
float depth_below(const SurfaceQuery& cloth, Vec3f at, Vec3f normal, float inwards_cm, float outwards_cm) {
  const SurfaceHit hit = cloth.first_hit(at - inwards_cm * normal, normal, inwards_cm + outwards_cm);
  return hit.found && dot(hit.normal, normal) > .1f ? hit.distance_cm - inwards_cm : INFINITY;
}

std::vector<char> covered(const Part& inner, const Outer& outer, float outwards_cm) {
  const std::vector<Vec3f> normals = normals_of(inner, inner.rest_cm);
  std::vector<char> is_covered(inner.rest_cm.size(), 0);
  for (size_t v = 0; v < normals.size(); ++v)
    if (dot(normals[v], normals[v]) > 0)
      is_covered[v] = std::isfinite(
          depth_below(outer.rest, inner.rest_cm[v], normals[v], outer.deepest_cm(inner), outwards_cm));
  return is_covered;
}

template <typename Use>
void for_corners(const Scan& mesh, uint32_t face, const Use& use) {
  for (uint32_t c = mesh.face_begin[face]; c < mesh.face_begin[face + 1]; ++c) use(mesh.corners[c].position);
}

bool all_corners(const Scan& mesh, uint32_t face, const std::vector<char>& flags) {
  bool all = true;
  for_corners(mesh, face, [&](uint32_t v) { all = all && flags[v]; });
  return all;
}

/// Vertices of the part that the garment's file hides: the body's own, or those of an inner garment all of
/// whose anchors are hidden.
std::vector<char> hidden_by(const Garment& garment, const Part& inner) {
  if (!inner.garment) return garment.hides;
  std::vector<char> hidden;
  for (const Anchor& anchor : inner.garment->anchors)
    hidden.push_back(std::all_of(anchor.vertices.begin(), anchor.vertices.end(),
                                 [&](uint32_t v) { return garment.hides[v] != 0; }));
  return hidden;
}

void drop_hidden(Part& inner, const Outer& outer) {
  if (inner.kind == PartKind::kHair || inner.kind == PartKind::kEyes) return;
  std::vector<char> hidden = hidden_by(*outer.part->garment, inner);
  const std::vector<char> is_covered = covered(inner, outer, kHides_cm);
  for (size_t v = 0; v < hidden.size(); ++v) hidden[v] = hidden[v] && is_covered[v];
  auto& faces = inner.faces;
  faces.erase(std::remove_if(faces.begin(), faces.end(),
                             [&](uint32_t face) { return all_corners(*inner.mesh, face, hidden); }),
              faces.end());
}

Vec3f middle_of(const Part& part, uint32_t face, const std::vector<Vec3f>& of) {
  Vec3f sum;
  float count = 0;
  for_corners(*part.mesh, face, [&](uint32_t v) { sum += of[v], ++count; });
  return sum / count;
}

/// Presses vertices below the cloth, then those of faces whose middle still comes through.
void press_below(Part& inner, const Outer& outer) {
  const std::vector<char> is_covered = covered(inner, outer, kCovers_cm);
  const std::vector<Vec3f> normals = normals_of(inner, inner.posed_cm);
  const auto missing = [&](Vec3f at, Vec3f normal) {
    const float depth = depth_below(outer.posed, at, normal, outer.deepest_cm(inner), kGap_cm);
    return std::isfinite(depth) ? std::max(0.0f, kGap_cm - depth) : 0.0f;
  };
  for (size_t v = 0; v < normals.size(); ++v)
    if (is_covered[v]) inner.posed_cm[v] += -missing(inner.posed_cm[v], normals[v]) * normals[v];
  for (int round = 0; round < 3; ++round) {
    std::vector<float> press(normals.size(), 0);
    for (const uint32_t face : inner.faces) {
      if (!all_corners(*inner.mesh, face, is_covered)) continue;
      const float by =
          missing(middle_of(inner, face, inner.posed_cm), normalised(middle_of(inner, face, normals)));
      if (by > .1f) for_corners(*inner.mesh, face, [&](uint32_t v) { press[v] = std::max(press[v], by); });
    }
    for (size_t v = 0; v < press.size(); ++v) inner.posed_cm[v] += -press[v] * normals[v];
  }
}

/// Drops the hair that still comes through a hat: the hat lies between it and the head, for which the eyes
/// stand.
void drop_hair_outside(Part& hair, const Outer& hat, Vec3f eyes) {
  auto& faces = hair.faces;
  const auto is_outside = [&](uint32_t face) {
    const Vec3f at = middle_of(hair, face, hair.posed_cm), to_eyes = eyes - at;
    return hat.posed.is_blocked(at, normalised(to_eyes), length(to_eyes));
  };
  faces.erase(std::remove_if(faces.begin(), faces.end(), is_outside), faces.end());
}

Vec3f mean_of(const std::vector<Vec3f>& positions) {
  Vec3f sum;
  for (const Vec3f& position : positions) sum += position;
  return sum / static_cast<float>(std::max<size_t>(positions.size(), 1));
}

/// Hair that hangs below the chin is lifted out of what it lies on.
void lift_hair(Part& hair, const std::vector<const Part*>& below, float chin_cm) {
  constexpr float kReach_cm = 5, kAbove_cm = .4f;
  std::vector<Vec3f> positions;
  std::vector<SurfaceTriangle> triangles;
  for (const Part* part : below) {
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), part->posed_cm.begin(), part->posed_cm.end());
    for (SurfaceTriangle triangle : triangles_of(*part)) {
      for (uint32_t& corner : triangle.corner) corner += first;
      triangles.push_back(triangle);
    }
  }
  const SurfaceQuery surface(std::move(positions), std::move(triangles));
  for (size_t v = 0; v < hair.posed_cm.size(); ++v) {
    if (hair.rest_cm[v].y > chin_cm) continue;
    const SurfaceHit near = surface.nearest(hair.posed_cm[v], kReach_cm);
    if (!near.found) continue;
    const Vec3f at = surface.at(near);
    if (dot(hair.posed_cm[v] - at, near.normal) < kAbove_cm) hair.posed_cm[v] = at + kAbove_cm * near.normal;
  }
}

}  // namespace

void settle_layers(Person& person) {
  // From the outside in: an outer layer stays where it is while those inside it move.
  for (size_t o = person.parts.size(); o-- > 1;) {
    if (person.parts[o].kind != PartKind::kClothes) continue;
    const Outer outer(person.parts[o]);
    const bool is_hat = person.parts[o].worn->slot == Slot::kHat;
    for (size_t i = 0; i < person.parts.size(); ++i) {
      Part& inner = person.parts[i];
      const bool is_hair = inner.kind == PartKind::kHair;
      const bool is_inside = i < o && inner.kind != PartKind::kEyes;
      if (!(is_hair ? is_hat : is_inside)) continue;
      drop_hidden(inner, outer);
      press_below(inner, outer);
      if (is_hair) drop_hair_outside(inner, outer, mean_of(person.parts[1].posed_cm));
    }
  }
  std::vector<const Part*> below;
  for (const Part& part : person.parts)
    if (part.kind == PartKind::kSkin || part.kind == PartKind::kClothes) below.push_back(&part);
  for (Part& part : person.parts)
    if (part.kind == PartKind::kHair) lift_hair(part, below, person.chin_cm);
}

Pokes find_pokes(const Person& person) {
  Pokes pokes;
  constexpr float kSkin_cm = .1f;
  for (size_t o = 1; o < person.parts.size(); ++o) {
    const Part& cloth = person.parts[o];
    if (cloth.kind != PartKind::kClothes) continue;
    const Outer outer(cloth);
    for (size_t i = 0; i < o; ++i) {
      const Part& inner = person.parts[i];
      if (inner.kind == PartKind::kEyes) continue;
      const std::vector<char> is_covered = covered(inner, outer, kCovers_cm);
      const std::vector<Vec3f> normals = normals_of(inner, inner.posed_cm);
      for (const uint32_t face : inner.faces) {
        if (!all_corners(*inner.mesh, face, is_covered)) continue;
        const float depth =
            -depth_below(outer.posed, middle_of(inner, face, inner.posed_cm),
                         normalised(middle_of(inner, face, normals)), outer.deepest_cm(inner), 0);
        if (!std::isfinite(depth) || depth < kSkin_cm) continue;
        const uint32_t begin = inner.mesh->face_begin[face];
        const auto at = [&](uint32_t k) { return inner.posed_cm[inner.mesh->corners[begin + k].position]; };
        pokes.area_cm2 += length(cross(at(1) - at(0), at(2) - at(0)));
        if (depth > pokes.depth_cm)
          pokes.depth_cm = depth, pokes.worst = inner.name + " through " + cloth.name;
      }
    }
  }
  return pokes;
}

}  // namespace ohb::people
