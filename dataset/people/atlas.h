// One UV atlas for all parts of a person: the assets' own charts, each as large as its surface is, packed
// without overlaps.
#pragma once

#include "dataset/people/person.h"

namespace ohb::people {

struct AtlasFace {
  uint32_t part = 0, face = 0;  // of the part's mesh
  uint32_t first_corner = 0;    // in Atlas::corner_uv
};

struct Atlas {
  int size_px = 0;
  float px_per_cm = 0;              // where the weight is 1
  std::vector<AtlasFace> faces;     // all kept faces, part by part
  std::vector<uint32_t> corner_uv;  // index into uvs
  std::vector<Vec2f> uvs;           // v up, in [0, 1]
  float used_share = 0;             // of the atlas, by the charts' boxes
};

/// Heads get 1.6 and eyes 2 times the texels a cm. Throws std::logic_error if there is nothing to pack.
Atlas pack_atlas(const Person& person, int size_px);

/// Where boxes of these sizes lie in a square of that size (lower left corners), or nothing if they do not
/// fit. In the given order, each at the lowest place on the skyline.
std::vector<Vec2f> pack_boxes(const std::vector<Vec2f>& sizes, float square);

}  // namespace ohb::people
