// Where along the seams the two sides must agree so that they do everywhere between, too.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "bake/seams.h"

namespace ohb::bake {

/// A point of a seam as two bilinear lookups.
struct SeamPlace {
  uint32_t texel[2][4];  // [side]; into SeamPlaces::texels
  float weight[2][4];
  uint32_t seam;
  float along;
};

using SeamPoint = std::pair<uint32_t, float>;  // seam, along

/// Between two neighbouring borders of the texels that either side reads, a difference of bilinear lookups
/// along an edge is a polynomial of degree 2. Places are both ends and the middle of each such piece: where a
/// quadratic is at most 1 there it is at most 5/4 on all of the piece.
struct SeamPlaces {
  std::vector<SeamPlace> places;     // edge by edge, along each from 0 to 1
  std::vector<uint32_t> texels;      // row x width + column, ascending: all that the places read
  std::vector<uint32_t> first_read;  // of each texel, into reads; and the end
  std::vector<uint32_t> reads;       // the places that read a texel

  /// `more`: places beside those, in ascending order.
  SeamPlaces(const std::vector<Seam>& seams, int width_px, int height_px,
             const std::vector<SeamPoint>& more = {});

 private:
  void link_texels(int width_px, int height_px);
};

constexpr float kQuadraticOvershoot = 1.25f;

}  // namespace ohb::bake
