// Which way the green channel of a tangent-space normal map points, from the picture itself.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/image.h"

namespace ohb::commands {

enum class NormalConvention {
  kOpenGl,   // +Y up: ours, Blender's, glTF's
  kDirectX,  // +Y down: flip the green channel
  kFlat,     // no relief to tell it from; either reading is right
  kUnclear,  // neither reading is clearly that of a surface
};
const char* name_of(NormalConvention convention);

struct NormalConventionResult {
  NormalConvention convention = NormalConvention::kUnclear;
  double curl_opengl = 0, curl_directx = 0;  // mean |curl| of the slopes under each reading
  double ratio = 0;                          // the larger over the smaller
  size_t texels = 0;                         // that were measured
  int level = 0;                             // at 1 / 2^level of the picture's size
  bool leans_to_opengl() const { return curl_opengl <= curl_directx; }
};

/// The slopes of a surface have no curl: with normal (x, y, z), p = -x/z and q = -y/z obey dp/dv = dq/du (u
/// to the right, v up). `image` has its values as stored, (n + 1) / 2. `region` gives the chart of each texel
/// (kNoRegion: none): only texels whose neighbourhood lies in one chart count. JPEG noise hides the answer in
/// fine texels, so the slopes are also averaged to 1/2, 1/4 and 1/8 of the size, and the clearest level with
/// at least 2000 texels (or the finest) is the answer. Ratios below 3 are unclear.
constexpr uint32_t kNoRegion = 0xffffffffu;
NormalConventionResult detect_normal_convention(const Image& image, const std::vector<uint32_t>& region);

}  // namespace ohb::commands
