// The background beside a chart's border holds what lies beyond it on the surface: the chart on the other
// side of the seam, carried over.
#pragma once

#include <vector>

#include "bake/seams.h"

namespace ohb::bake {

/// How far from the border it reaches: bilinear lookups at mip level 4 reach 2 blocks of 16 texels.
constexpr int kSeamBand_px = 32;

/// For each texel of the background within kSeamBand_px of a seam, the place beyond it that it shows. At most
/// 24 bytes a texel, of the band only.
class SeamBand {
 public:
  /// Texels with is_face 0 belong to the nearest seam edge on whose outer side they lie. `seams` must outlive
  /// this; maps are at most 65535 texels wide and high.
  SeamBand(const std::vector<Seam>& seams, const std::vector<uint8_t>& is_face, int width_px, int height_px);

  /// Fills the band of one image of any number of channels (normals: 3): the edge's turn, scale and mirroring
  /// carry each texel into the chart on the other side (as Blender's "adjacent faces" margin), where covered
  /// texels are read bilinearly; tangent-space normals go through the model's frame into that of the chart
  /// beside the texel. Gives what is covered afterwards: texels whose other side is not wholly covered are
  /// left alone.
  std::vector<uint8_t> fill(Image& map, const std::vector<uint8_t>& is_covered, bool is_normals) const;

 private:
  static constexpr uint32_t kNone = 0xffffffffu;
  /// A seam's side in texel space: y down, centres at whole numbers.
  struct Placed {
    Vec2f from, to, inward;  // inward: unit, into the triangle
    float length_px;
    Placed(const SeamSide& side, int width_px, int height_px);
  };
  /// A point beside an edge: how far outwards, how far along (0 to 1 on it), how far from it.
  struct Beside {
    float outward_px, along, squared_distance;
    Beside(const Placed& edge, Vec2f point);
  };
  struct RowBand;
  std::vector<RowBand> row_bands() const;
  /// A texel of the band, the side beside it, and the bilinear lookup that it shows.
  struct Carried {
    uint32_t texel, side;
    uint16_t x, y;  // upper left of the four texels that are read
    float right, down;
    float along;  // of the edge, 0 to 1
  };
  /// A tangent-space normal of the other side, in the frame beside the texel.
  Vec3f turned(Vec3f normal, const Carried& to) const;
  std::vector<uint32_t> claim_texels(const RowBand& band, const std::vector<uint8_t>& is_face) const;
  std::vector<Carried> carried_in(const RowBand& band, const std::vector<uint8_t>& is_face) const;

  const std::vector<Seam>& seams_;
  int width_px_, height_px_;
  std::vector<Placed> placed_;  // 2 x seam + side; used while carried_ is made
  std::vector<Carried> carried_;
};

}  // namespace ohb::bake
