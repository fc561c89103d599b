#include "dataset/people/looks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "dataset/model/colour.h"
#include "dataset/model/mesh_topology.h"
#include "dataset/model/noise.h"

namespace ohb::people {
namespace {

float luminance(Vec3f c) {
  return .2126f * c.x + .7152f * c.y + .0722f * c.z;
}

/// Distance to the border between the two nearest points of a jittered lattice (Worley 1996): 0 in the
/// creases of a grain, up to about 1 in the middle of its cells.
float grain(Vec3f p) {
  const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y)),
            z = static_cast<int>(std::floor(p.z));
  float nearest = 9, second = 9;
  for (int k = 0; k < 27; ++k) {
    const int i = x + k % 3 - 1, j = y + k / 3 % 3 - 1, l = z + k / 9 - 1;
    const uint64_t number = cell_key(i, j, l, 1);
    const Vec3f point{static_cast<float>(i) + static_cast<float>(number >> 48) * 0x1p-16f,
                      static_cast<float>(j) + static_cast<float>(number >> 32 & 0xffff) * 0x1p-16f,
                      static_cast<float>(l) + static_cast<float>(number >> 16 & 0xffff) * 0x1p-16f};
    const float distance = length(p - point);
    if (distance < nearest)
      second = nearest, nearest = distance;
    else
      second = std::min(second, distance);
  }
  return second - nearest;
}

/// 1 where the second colour shows, with edges as wide as a thread.
float pattern_share(int pattern, Vec2f cm, float period_cm) {
  const auto band = [&](float x, float share) {
    const float place = x / period_cm - std::floor(x / period_cm), edge = .08f / period_cm;
    return smooth(0, edge, place) * (1 - smooth(share, share + edge, place));
  };
  switch (pattern) {
    case 0:
      return band(cm.y, .4f);
    case 1:
      return band(cm.x, .25f);
    case 2:
      return .5f * (band(cm.x, .45f) + band(cm.y, .45f));
    case 3: {
      const float x = cm.x / period_cm, y = cm.y / period_cm;
      const float shift = (static_cast<int>(std::floor(y)) & 1) ? .5f : 0;
      const Vec2f from{x + shift - std::floor(x + shift) - .5f, y - std::floor(y) - .5f};
      return 1 - smooth(.24f, .28f, std::sqrt(dot(from, from)));
    }
    default:
      return (static_cast<int>(std::floor(cm.y / (6 * period_cm))) & 1) ? 1.0f : 0.0f;
  }
}

/// Heights and area of a piece of cloth.
struct Extent {
  float low = INFINITY, high = -INFINITY, area = 0, moment = 0;
  void add(Vec3f at) { low = std::min(low, at.y), high = std::max(high, at.y); }
  void add(const Extent& other) {
    low = std::min(low, other.low), high = std::max(high, other.high);
    area += other.area, moment += other.moment;
  }
};

/// Shoes come with socks in one mesh: the pieces that begin above the sole and reach far above the shoe.
class Socks {
 public:
  explicit Socks(const std::map<uint32_t, Extent>& pieces) {
    for (const auto& [key, piece] : pieces) sole_ = std::min(sole_, piece.low);
    for (const auto& [key, piece] : pieces)
      if (piece.low < sole_ + kSole_cm) top_ = std::max(top_, piece.high);
  }
  bool holds(const Extent& piece) const {
    return piece.low >= sole_ + kSole_cm && piece.high > top_ + kAbove_cm;
  }

 private:
  static constexpr float kSole_cm = 2, kAbove_cm = 5;
  float sole_ = INFINITY, top_ = -INFINITY;
};

}  // namespace

Look::Look(const Person& person, const Part& part) : kind_(part.kind), worn_(part.worn) {
  const AssetMaterial& material = part.material;
  Vec3f plain;
  for (int i = 0; i < 3; ++i) plain[i] = srgb_to_linear(std::clamp(material.diffuse_colour[i], 0.0f, 1.0f));
  picture_ = material.diffuse.empty() ? std::make_shared<Picture>(plain)
                                      : std::make_shared<Picture>(material.diffuse);
  if (kind_ == PartKind::kSkin) target_ = person.recipe->skin_tone;
  if (kind_ == PartKind::kHair || kind_ == PartKind::kBrows) target_ = person.recipe->hair_colour;
  if (kind_ == PartKind::kClothes) find_zones(person, part);
  find_means(part);
}

void Look::find_zones(const Person& person, const Part& part) {
  const Scan& mesh = *part.mesh;
  // Pieces hang together in space; one that reaches far above and below the hips is told apart by its UV
  // charts.
  DisjointSets pieces(mesh.positions.size()), charts(mesh.uvs.size());
  for (size_t face = 0; face < mesh.face_count(); ++face)
    for (uint32_t c = mesh.face_begin[face] + 1; c < mesh.face_begin[face + 1]; ++c) {
      pieces.join(mesh.corners[mesh.face_begin[face]].position, mesh.corners[c].position);
      charts.join(mesh.corners[mesh.face_begin[face]].uv, mesh.corners[c].uv);
    }
  std::map<uint32_t, Extent> of_piece, of_chart;
  float whole = 0;
  for (const SurfaceTriangle& triangle : triangles_of(part)) {
    Extent extent;
    for (const uint32_t corner : triangle.corner) extent.add(part.rest_cm[corner]);
    const Vec3f a = part.rest_cm[triangle.corner[0]];
    extent.area =
        .5f * length(cross(part.rest_cm[triangle.corner[1]] - a, part.rest_cm[triangle.corner[2]] - a));
    extent.moment = extent.area * .5f * (extent.low + extent.high);
    of_piece[pieces.find(triangle.corner[0])].add(extent);
    of_chart[charts.find(mesh.corners[mesh.face_begin[triangle.face]].uv)].add(extent);
    whole += extent.area;
  }
  constexpr float kDetailShare = .03f, kFar_cm = 15;
  const Socks socks(of_piece);
  zones_.resize(mesh.face_count());
  for (size_t face = 0; face < mesh.face_count(); ++face) {
    const Corner corner = mesh.corners[mesh.face_begin[face]];
    const Extent& piece = of_piece[pieces.find(corner.position)];
    const bool is_both = piece.low < person.hips_cm - kFar_cm && piece.high > person.hips_cm + kFar_cm;
    const Extent& body = is_both ? of_chart[charts.find(corner.uv)] : piece;
    zones_[face] = piece.area < kDetailShare * whole ? kDetail : body.moment > body.area * person.hips_cm;
    if (worn_->slot == Slot::kShoes && socks.holds(piece)) zones_[face] = kSock;
  }
}

void Look::find_means(const Part& part) {
  Vec3f sum[4];
  float weight[4] = {}, area_cm2 = 0, area_uv = 0;
  const Scan& mesh = *part.mesh;
  for (const uint32_t face : part.faces) {
    const Corner* corner = &mesh.corners[mesh.face_begin[face]];
    const uint32_t count = mesh.face_begin[face + 1] - mesh.face_begin[face];
    Vec2f uv;
    for (uint32_t k = 0; k < count; ++k) uv = uv + (1 / static_cast<float>(count)) * mesh.uvs[corner[k].uv];
    const Vec3f a = part.rest_cm[corner[0].position];
    const float size =
        length(cross(part.rest_cm[corner[1].position] - a, part.rest_cm[corner[2].position] - a));
    const float opacity = picture_->opacity(uv);
    const uint8_t zone = zone_of(face);
    sum[zone] += size * opacity * picture_->colour(uv), weight[zone] += size * opacity;
    area_cm2 += size;
    area_uv += std::fabs(cross(mesh.uvs[corner[1].uv] - mesh.uvs[corner[0].uv],
                               mesh.uvs[corner[2].uv] - mesh.uvs[corner[0].uv]));
  }
  for (int zone = 0; zone < 4; ++zone)
    mean_[zone] = weight[zone] > 0 ? sum[zone] / weight[zone] : Vec3f{.5f, .5f, .5f};
  if (area_uv > 0) cm_per_uv_ = std::sqrt(area_cm2 / area_uv);
}

Vec3f Look::colour(uint8_t zone, Vec2f uv, Vec3f rest_cm) const {
  if (kind_ == PartKind::kClothes) return garment_colour(zone, uv, rest_cm);
  const Vec3f own = picture_->colour(uv);
  if (kind_ == PartKind::kEyes) return own;
  constexpr float kLeast = .25f, kMost = 4;
  Vec3f out;
  for (int i = 0; i < 3; ++i)
    out[i] = own[i] * std::clamp(target_[i] / std::max(mean_[0][i], .004f), kLeast, kMost);
  return out;
}

Vec3f Look::garment_colour(uint8_t zone, Vec2f uv, Vec3f rest_cm) const {
  const Vec3f own = picture_->colour(uv);
  if (zone >= kDetail) return own;
  const ZoneLook& look = worn_->zones[zone];
  if (look.kind == kAsItIs) return own;
  const Vec3f mean = mean_[zone];
  // Folds and seams: light against the mean, of which dark pictures have little and noise.
  constexpr float kFloor = .02f;
  const float shade = std::clamp((luminance(own) + kFloor) / (luminance(mean) + kFloor), .3f, 1.6f);
  Vec3f colour = look.colour;
  if (look.kind == kPattern) {
    const float share = pattern_share(look.pattern, cm_per_uv_ * uv, look.pattern_cm);
    colour = (1 - share) * look.colour + share * look.second;
  }
  // Trims and prints, whose hue is not the cloth's, take the second colour.
  const auto hue = [](Vec3f c) { return c / std::max(c.x + c.y + c.z, .01f); };
  const float apart = length(hue(own) - hue(mean));
  const float trim =
      look.kind == kLeatherLook ? 0 : smooth(.25f, .4f, apart) * smooth(.02f, .08f, luminance(own));
  colour = (1 - trim) * colour + trim * look.second;
  float texture = 1;
  if (look.kind == kLeatherLook) {
    const Vec3f place = rest_cm / look.grain_cm;
    const float crease = 1 - smooth(0, .22f, grain(place));
    const float wear = value_noise(rest_cm / 5, 7) + .5f * value_noise(rest_cm / 1.7f, 8);
    texture = (1 - .3f * crease) * (.8f + .27f * wear);
    return texture * std::pow(shade, 1.2f) * colour;
  }
  texture = .94f + .12f * value_noise(rest_cm / .18f, 9);
  return texture * shade * colour;
}

MaterialClass Look::class_of(uint8_t zone) const {
  if (kind_ == PartKind::kSkin || kind_ == PartKind::kEyes) return kSkin;
  if (kind_ == PartKind::kHair || kind_ == PartKind::kBrows) return kHair;
  if (zone == kSock) return kFabric;
  if (worn_->is_leather) return kLeather;
  if (zone == kDetail)
    return worn_->zones[0].kind == kLeatherLook && worn_->zones[1].kind == kLeatherLook ? kLeather : kFabric;
  return worn_->zones[zone].kind == kLeatherLook ? kLeather : kFabric;
}

}  // namespace ohb::people
