// Makes both sides of each seam read the same value, at every mip level that a renderer may look up.
#pragma once

#include <vector>

#include "bake/seams.h"

namespace ohb::bake {

constexpr int kMendRounds = 2;
constexpr int kMendSweeps = 12;

/// What the mending of all maps of one set shares: which blocks of texels the lookups along the seams read at
/// some mip levels, two lookups a block's length.
///
/// Kaczmarz's method (1937), damped: lookups on the two sides of a seam that differ are each moved half the
/// way by the least change of the texels that they read, edge by edge, coarse levels first, over and over
/// until they agree within a tolerance. Blocks of coarse levels are means of texels, of which those of the
/// background change, all of a block alike; at level 0 texels inside triangles give way too, a tenth as much.
/// The texels themselves are changed at the end of each round only: until then a block knows what it and the
/// blocks that it is part of were moved by.
class SeamMender {
 public:
  /// Coarser levels than these two depend on texels of other charts wherever charts lie closer than the
  /// blocks are long, and making all of them agree would spoil level 0.
  static constexpr int kMostLevels = 2;

  /// is_inside: 1 for texels whose centre lies in a triangle. `levels`: from 0 on, up to kMostLevels.
  /// Arguments must outlive this.
  SeamMender(const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside, int width_px,
             int height_px, int levels = kMostLevels);

  /// The order is fixed, so are the bits. Normals stay unit vectors, other values within [0,1]. Gives the
  /// greatest change of a texel inside a triangle. Several maps may be mended at once.
  float mend(Image& map, MapValues values, float tolerance) const;

 private:
  static constexpr uint32_t kNone = 0xffffffffu;
  /// A place on a seam at one level: what its two sides read.
  struct Place {
    uint32_t block[2][4];  // into blocks_
    float weight[2][4];
    float along;
    float step;  // what a difference of 1 moves each block by, times its weight and give
  };
  struct Block {
    uint32_t index;    // row x columns + column of its level
    uint32_t part_of;  // the block of the coarser level, or kNone
    float background;  // share of its texels
    float give;
    uint8_t level;
  };
  class Solver;
  int columns_of(int level) const { return (width_px_ + (1 << level) - 1) >> level; }
  template <typename Visit>
  void for_each_texel(const Block& block, const Visit& visit) const;
  std::vector<Place> places_of(uint32_t seam, int level) const;
  void collect_places();
  void link_blocks();
  void order_blocks();

  const std::vector<Seam>& seams_;
  const std::vector<uint8_t>& is_inside_;
  int width_px_, height_px_, levels_;
  std::vector<Place> places_;  // edge by edge, coarse levels first
  std::vector<uint8_t> place_level_;
  std::vector<size_t> place_begin_;  // of each edge, and the end
  std::vector<Block> blocks_;        // level by level, in the order in which the places read them
  size_t texels_end_ = 0;            // blocks_ before it are of level 0
};

}  // namespace ohb::bake
