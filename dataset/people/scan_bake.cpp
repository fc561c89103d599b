#include "dataset/people/scan_bake.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/model/colour.h"
#include "dataset/people/looks.h"
#include "dataset/people/visible_faces.h"
#include "dataset/surface/padding.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::people {
namespace {

/// Brow cards over the skin, at rest.
struct Brows {
  SurfaceQuery cards;
  const Part* part;
  Look look;
  Vec3f low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};

  Brows(const Person& person, const Part& p) : cards(p.rest_cm, triangles_of(p)), part(&p), look(person, p) {
    constexpr float kAround_cm = .5f;
    for (const Vec3f& position : p.rest_cm)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], position[axis] - kAround_cm);
        high[axis] = std::max(high[axis], position[axis] + kAround_cm);
      }
  }

  /// The skin's colour with the brow over it, seen along the normal.
  Vec3f over(Vec3f skin, Vec3f at, Vec3f normal) const {
    for (int axis = 0; axis < 3; ++axis)
      if (at[axis] < low[axis] || at[axis] > high[axis]) return skin;
    constexpr float kReach_cm = .6f;
    const SurfaceHit hit = cards.first_hit(at + kReach_cm * normal, -normal, 2 * kReach_cm);
    if (!hit.found) return skin;
    const Scan& mesh = *part->mesh;
    const SurfaceTriangle& triangle = cards.triangles()[hit.triangle];
    Vec2f uv;
    const float weights[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    for (uint32_t c = mesh.face_begin[triangle.face]; c < mesh.face_begin[triangle.face + 1]; ++c)
      for (int k = 0; k < 3; ++k)
        if (mesh.corners[c].position == triangle.corner[k])
          uv = uv + weights[k] * mesh.uvs[mesh.corners[c].uv];
    const float opacity = std::clamp(look.opacity(uv), 0.0f, 1.0f);
    return (1 - opacity) * skin + opacity * (.7f * look.colour(0, uv, at));
  }
};

/// A triangle of the atlas and what it shows.
struct Shown {
  uint32_t atlas_face;
  uint32_t corner[3];  // of the face
};

class Painter {
 public:
  /// `shades`: of each part's vertices, or none at all.
  Painter(const Person& person, const Atlas& atlas, const std::vector<Look>& looks,
          const std::vector<std::vector<uint8_t>>& zones, std::vector<std::vector<float>> shades)
      : person_(person), atlas_(atlas), looks_(looks), zones_(zones), shades_(std::move(shades)) {
    for (const Part& part : person.parts)
      if (part.kind == PartKind::kBrows) brows_ = std::make_unique<Brows>(person, part);
    for (uint32_t f = 0; f < atlas.faces.size(); ++f) {
      const AtlasFace& face = atlas.faces[f];
      const Scan& mesh = *person.parts[face.part].mesh;
      const uint32_t count = mesh.face_begin[face.face + 1] - mesh.face_begin[face.face];
      for (uint32_t k = 1; k + 1 < count; ++k) {
        shown_.push_back({f, {0, k, k + 1}});
        surface::UvTriangle triangle;
        for (int i = 0; i < 3; ++i)
          triangle.uv[i] = atlas.uvs[atlas.corner_uv[face.first_corner + shown_.back().corner[i]]];
        triangles_.push_back(triangle);
      }
    }
  }

  ByteImage paint() const {
    const int size = atlas_.size_px;
    const surface::TexelCoverage coverage = surface::cover_texels(triangles_, size, size);
    Image linear(size, size, 3);
    std::vector<uint8_t> is_covered(coverage.owner.size(), 0);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const uint32_t owner = coverage.owner_of(x, y);
        if (owner == surface::TexelCoverage::kNone) continue;
        is_covered[static_cast<size_t>(y) * static_cast<size_t>(size) + static_cast<size_t>(x)] = 1;
        const Vec3f colour = colour_of_texel(owner, x, y);
        for (int c = 0; c < 3; ++c) linear.pixel(x, y)[c] = colour[c];
      }
    surface::pad(linear, is_covered);
    return encoded(linear);
  }

 private:
  Vec3f colour_of_texel(uint32_t owner, int x, int y) const {
    // Two points on a diagonal: the pictures are hardly finer than the atlas.
    constexpr float kPlaces[2][2] = {{.25f, .25f}, {.75f, .75f}};
    Vec3f sum;
    for (const auto& place : kPlaces) {
      const auto size = static_cast<float>(atlas_.size_px);
      sum += colour_at(
          owner, {(static_cast<float>(x) + place[0]) / size, 1 - (static_cast<float>(y) + place[1]) / size});
    }
    return sum / 2;
  }

  Vec3f colour_at(uint32_t owner, Vec2f uv) const {
    float weight[3];
    weights_in(triangles_[owner], uv, weight);
    const Shown& shown = shown_[owner];
    const AtlasFace& face = atlas_.faces[shown.atlas_face];
    const Part& part = person_.parts[face.part];
    const Scan& mesh = *part.mesh;
    Vec2f source;
    Vec3f rest, at[3];
    float shade = shades_.empty() ? 1.0f : 0.0f;
    for (int k = 0; k < 3; ++k) {
      const Corner corner = mesh.corners[mesh.face_begin[face.face] + shown.corner[k]];
      source = source + weight[k] * mesh.uvs[corner.uv];
      at[k] = part.rest_cm[corner.position];
      rest += weight[k] * at[k];
      if (!shades_.empty()) shade += weight[k] * shades_[face.part][corner.position];
    }
    const Vec3f colour = looks_[face.part].colour(zones_[face.part][face.face], source, rest);
    if (part.kind != PartKind::kSkin || !brows_) return shade * colour;
    return shade * brows_->over(colour, rest, normalised(cross(at[1] - at[0], at[2] - at[0])));
  }

  /// Barycentric weights, moved into the triangle.
  static void weights_in(const surface::UvTriangle& t, Vec2f uv, float (&weight)[3]) {
    const Vec2f ab = t.uv[1] - t.uv[0], ac = t.uv[2] - t.uv[0], ap = uv - t.uv[0];
    const float area = cross(ab, ac);
    weight[1] = area != 0 ? std::clamp(cross(ap, ac) / area, 0.0f, 1.0f) : 0;
    weight[2] = area != 0 ? std::clamp(cross(ab, ap) / area, 0.0f, 1.0f) : 0;
    const float sum = weight[1] + weight[2];
    if (sum > 1) weight[1] /= sum, weight[2] /= sum;
    weight[0] = std::max(0.0f, 1 - weight[1] - weight[2]);
  }

  static ByteImage encoded(const Image& linear) {
    // Steps fine enough that the darkest shades come out right too.
    constexpr int kSteps = 1 << 14;
    static const std::vector<uint8_t> table = [] {
      std::vector<uint8_t> bytes(kSteps + 1);
      for (int i = 0; i <= kSteps; ++i)
        bytes[static_cast<size_t>(i)] =
            static_cast<uint8_t>(std::lround(255 * linear_to_srgb(static_cast<float>(i) / kSteps)));
      return bytes;
    }();
    ByteImage image(linear.width_px, linear.height_px, 3);
    for (size_t i = 0; i < image.values.size(); ++i)
      image.values[i] =
          table[static_cast<size_t>(std::lround(kSteps * std::clamp(linear.values[i], 0.0f, 1.0f)))];
    return image;
  }

  const Person& person_;
  const Atlas& atlas_;
  const std::vector<Look>& looks_;
  const std::vector<std::vector<uint8_t>>& zones_;
  std::vector<std::vector<float>> shades_;
  std::unique_ptr<Brows> brows_;
  std::vector<Shown> shown_;
  std::vector<surface::UvTriangle> triangles_;
};

/// Positions that the kept faces use, faces and classes, in the atlas's order.
void write_mesh(const Person& person, const Atlas& atlas, const std::vector<Look>& looks,
                const std::vector<std::vector<uint8_t>>& zones, ScannedPerson& scan) {
  std::vector<std::vector<uint32_t>> place(person.parts.size());
  for (const AtlasFace& face : atlas.faces) {
    const Part& part = person.parts[face.part];
    const Scan& mesh = *part.mesh;
    std::vector<uint32_t>& places = place[face.part];
    places.resize(part.posed_cm.size(), Corner::kNoUv);
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    const uint32_t begin = mesh.face_begin[face.face], count = mesh.face_begin[face.face + 1] - begin;
    for (uint32_t k = 0; k < count; ++k) {
      uint32_t& at = places[mesh.corners[begin + k].position];
      if (at == Corner::kNoUv) {
        at = static_cast<uint32_t>(scan.positions_cm.size());
        scan.positions_cm.push_back(part.posed_cm[mesh.corners[begin + k].position]);
      }
      scan.corners.push_back({at, atlas.corner_uv[face.first_corner + k]});
    }
    scan.face_class.push_back(looks[face.part].class_of(zones[face.part][face.face]));
    scan.part_of_face.push_back(part.name);
  }
  scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
  scan.uvs = atlas.uvs;
}

}  // namespace

ScannedPerson scan_person(Person person, const ScanOptions& options) {
  std::vector<Look> looks;
  std::vector<std::vector<uint8_t>> zones;
  for (Part& part : person.parts) {
    looks.emplace_back(person, part);
    const Look& look = looks.back();
    if (part.kind == PartKind::kHair && part.faces.size() < 3000) split_faces(part);
    if (part.kind != PartKind::kSkin && part.kind != PartKind::kBrows)
      drop_empty_faces(part, [&](Vec2f uv) { return look.opacity(uv); });
    std::vector<uint8_t> zone(part.mesh->face_count(), 0);
    if (part.kind == PartKind::kClothes)
      for (uint32_t face = 0; face < zone.size(); ++face) zone[face] = look.zone_of(face);
    zones.push_back(std::move(zone));
  }
  ScannedPerson scan;
  scan.unseen_faces = drop_unseen_faces(person);
  if (options.faults.holes > 0) cut_holes(person, options.faults.holes);
  stand_on_ground(person);
  std::vector<std::vector<float>> shades;
  if (options.faults.shading) shades = soft_shading(person);
  if (options.faults.noise_cm > 0) add_noise(person, options.faults.noise_cm);
  const Atlas atlas = pack_atlas(person, options.atlas_px);
  scan.px_per_cm = atlas.px_per_cm;
  write_mesh(person, atlas, looks, zones, scan);
  scan.picture = Painter(person, atlas, looks, zones, std::move(shades)).paint();
  return scan;
}

}  // namespace ohb::people
