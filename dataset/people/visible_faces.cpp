#include "dataset/people/visible_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace ohb::people {
namespace {

constexpr float kFar_cm = 500, kStart_cm = 0.05f;
constexpr int kDirections = 48;

/// Evenly spread over the sphere (Fibonacci lattice).
std::vector<Vec3f> directions() {
  std::vector<Vec3f> all;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2.0 * i + 1) / kDirections, radius = std::sqrt(1 - z * z);
    const double turn = 2.399963229728653 * i;
    all.push_back({static_cast<float>(radius * std::cos(turn)), static_cast<float>(z),
                   static_cast<float>(radius * std::sin(turn))});
  }
  return all;
}

bool point_is_seen(const SurfaceQuery& all, Vec3f at, Vec3f normal, bool from_both_sides,
                   const std::vector<Vec3f>& ways) {
  for (const Vec3f& way : ways) {
    const float side = dot(way, normal);
    if (std::fabs(side) < .05f || (side < 0 && !from_both_sides)) continue;
    const Vec3f start = at + (side < 0 ? -kStart_cm : kStart_cm) * normal;
    if (!all.is_blocked(start, way, kFar_cm)) return true;
  }
  return false;
}

bool face_is_seen(const SurfaceQuery& all, const Part& part, uint32_t face, const std::vector<Vec3f>& ways) {
  const Scan& mesh = *part.mesh;
  const uint32_t begin = mesh.face_begin[face], end = mesh.face_begin[face + 1];
  const auto corner = [&](uint32_t c) { return part.posed_cm[mesh.corners[c].position]; };
  Vec3f middle;
  for (uint32_t c = begin; c < end; ++c) middle += corner(c);
  middle *= 1 / static_cast<float>(end - begin);
  const Vec3f a = corner(begin), b = corner(begin + 1), c = corner(begin + 2);
  const Vec3f normal =
      normalised(end - begin == 4 ? cross(c - a, corner(begin + 3) - b) : cross(b - a, c - a));
  if (!(dot(normal, normal) > .5f)) return false;
  const bool both = part.kind == PartKind::kClothes || part.kind == PartKind::kHair;
  if (point_is_seen(all, middle, normal, both, ways)) return true;
  for (uint32_t k = begin; k < end; ++k)
    if (point_is_seen(all, .75f * corner(k) + .25f * middle, normal, both, ways)) return true;
  return false;
}

}  // namespace

SurfaceQuery surface_of(const Person& person) {
  std::vector<Vec3f> positions;
  std::vector<SurfaceTriangle> triangles;
  for (const Part& part : person.parts) {
    if (part.kind == PartKind::kBrows) continue;
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), part.posed_cm.begin(), part.posed_cm.end());
    for (SurfaceTriangle triangle : triangles_of(part)) {
      for (uint32_t& corner : triangle.corner) corner += first;
      triangles.push_back(triangle);
    }
  }
  return SurfaceQuery(std::move(positions), std::move(triangles));
}

size_t drop_unseen_faces(Person& person) {
  const SurfaceQuery all = surface_of(person);
  const std::vector<Vec3f> ways = directions();
  size_t dropped = 0;
  for (Part& part : person.parts) {
    if (part.kind == PartKind::kBrows) continue;
    std::vector<char> is_seen(part.faces.size()), touches(part.posed_cm.size(), 0);
    for (size_t i = 0; i < part.faces.size(); ++i) {
      is_seen[i] = face_is_seen(all, part, part.faces[i], ways);
      const uint32_t face = part.faces[i];
      for (uint32_t c = part.mesh->face_begin[face]; is_seen[i] && c < part.mesh->face_begin[face + 1]; ++c)
        touches[part.mesh->corners[c].position] = 1;
    }
    std::vector<uint32_t> kept;
    for (const uint32_t face : part.faces) {
      bool keep = false;
      for (uint32_t c = part.mesh->face_begin[face]; c < part.mesh->face_begin[face + 1]; ++c)
        keep = keep || touches[part.mesh->corners[c].position];
      if (keep) kept.push_back(face);
    }
    dropped += part.faces.size() - kept.size();
    part.faces = std::move(kept);
  }
  return dropped;
}

namespace {

/// Copies a mesh's kept faces, each split in four.
class FaceSplitter {
 public:
  explicit FaceSplitter(const Part& part) : part_(part), from_(*part.mesh) {
    mesh_.materials = from_.materials, mesh_.groups = from_.groups;
    mesh_.uvs = from_.uvs;
    rest_ = part.rest_cm, posed_ = part.posed_cm, bones_ = part.bones;
  }

  void split_into(Part& part) {
    for (const uint32_t face : part_.faces) split(face);
    mesh_.face_begin.push_back(static_cast<uint32_t>(mesh_.corners.size()));
    mesh_.positions.resize(rest_.size());
    part.faces.clear();
    for (uint32_t face = 0; face + 1 < mesh_.face_begin.size(); ++face) part.faces.push_back(face);
    part.mesh = std::make_shared<const Scan>(std::move(mesh_));
    part.rest_cm = std::move(rest_), part.posed_cm = std::move(posed_), part.bones = std::move(bones_);
  }

 private:
  void split(uint32_t face) {
    const uint32_t begin = from_.face_begin[face], count = from_.face_begin[face + 1] - begin;
    std::vector<Corner> corners, middles;
    for (uint32_t k = 0; k < count; ++k) corners.push_back(from_.corners[begin + k]);
    for (uint32_t k = 0; k < count; ++k) middles.push_back(middle_of(corners[k], corners[(k + 1) % count]));
    if (count == 3) {
      for (uint32_t k = 0; k < 3; ++k) add({middles[(k + 2) % 3], corners[k], middles[k]});
      return add({middles[0], middles[1], middles[2]});
    }
    const Corner centre = new_corner(corners);
    for (uint32_t k = 0; k < count; ++k)
      add({corners[k], middles[k], centre, middles[(k + count - 1) % count]});
  }

  Corner middle_of(Corner a, Corner b) {
    if (b.position < a.position) std::swap(a, b);
    const auto key = std::array<uint32_t, 4>{a.position, b.position, a.uv, b.uv};
    const auto known = middles_.find(key);
    if (known != middles_.end()) return known->second;
    // Faces on both sides of a seam share the position.
    Corner middle = new_corner({a, b});
    const auto place = places_.emplace(std::pair{a.position, b.position}, middle.position);
    middle.position = place.first->second;
    return middles_[key] = middle;
  }

  Corner new_corner(const std::vector<Corner>& of) {
    const float share = 1 / static_cast<float>(of.size());
    Vec3f rest, posed;
    Vec2f uv;
    for (const Corner& corner : of) {
      rest += share * rest_[corner.position], posed += share * posed_[corner.position];
      uv = uv + share * mesh_.uvs[corner.uv];
    }
    rest_.push_back(rest), posed_.push_back(posed), mesh_.uvs.push_back(uv);
    bones_.push_back(bones_[of[0].position]);
    return {static_cast<uint32_t>(rest_.size() - 1), static_cast<uint32_t>(mesh_.uvs.size() - 1)};
  }

  void add(const std::vector<Corner>& corners) {
    mesh_.face_begin.push_back(static_cast<uint32_t>(mesh_.corners.size()));
    mesh_.corners.insert(mesh_.corners.end(), corners.begin(), corners.end());
  }

  const Part& part_;
  const Scan& from_;
  Scan mesh_;
  std::vector<Vec3f> rest_, posed_;
  std::vector<VertexBones> bones_;
  std::map<std::array<uint32_t, 4>, Corner> middles_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> places_;
};

}  // namespace

void split_faces(Part& part) {
  FaceSplitter(part).split_into(part);
}

void drop_empty_faces(Part& part, const Opacity& opacity) {
  constexpr float kEmptiest = .55f;
  constexpr int kSamples = 5;
  const Scan& mesh = *part.mesh;
  const auto is_empty = [&](uint32_t face) {
    const Corner* corner = &mesh.corners[mesh.face_begin[face]];
    const bool is_quad = mesh.face_begin[face + 1] - mesh.face_begin[face] == 4;
    float sum = 0;
    int count = 0;
    for (int i = 0; i < kSamples; ++i)
      for (int j = 0; j < kSamples; ++j) {
        const float s = (static_cast<float>(i) + .5f) / kSamples,
                    t = (static_cast<float>(j) + .5f) / kSamples;
        if (!is_quad && s + t > 1) continue;
        const Vec2f a = mesh.uvs[corner[0].uv], b = mesh.uvs[corner[1].uv], c = mesh.uvs[corner[2].uv];
        const Vec2f uv =
            is_quad ? (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * mesh.uvs[corner[3].uv] + s * c)
                    : (1 - s - t) * a + s * b + t * c;
        sum += opacity(uv), ++count;
      }
    return sum < kEmptiest * static_cast<float>(count);
  };
  part.faces.erase(std::remove_if(part.faces.begin(), part.faces.end(), is_empty), part.faces.end());
}

}  // namespace ohb::people
