#include "renderer/texels.h"

namespace ohb {
namespace {

uint16_t to_half(float value) {
  return imath_float_to_half(value);
}

}  // namespace

Texels::Texels(const TextureSet& set)
    : width_px_(set.albedo.width_px),
      height_px_(set.albedo.height_px),
      has_alpha_(!set.alpha.values.empty()) {
  const size_t count = static_cast<size_t>(width_px_) * height_px_;
  surface_.resize(count);
  for (size_t i = 0; i < count; ++i) {
    uint16_t* v = surface_[i].values;
    for (int c = 0; c < 3; ++c) v[c] = to_half(set.albedo.values[3 * i + c]);
    v[3] = to_half(has_alpha_ ? set.alpha.values[i] : 1.0f);
    v[4] = to_half(set.roughness.values[i]);
    v[5] = to_half(set.specular.values[i]);
    v[6] = to_half(set.sss.values[i]);
    v[7] = 0;
  }
  if (set.normal.values.empty()) return;
  normals_.resize(count);
  for (size_t i = 0; i < count; ++i)
    normals_[i] = {to_half(set.normal.values[3 * i]), to_half(set.normal.values[3 * i + 1]),
                   to_half(set.normal.values[3 * i + 2]), 0};
}

}  // namespace ohb
