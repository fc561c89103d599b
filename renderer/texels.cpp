#include "renderer/texels.h"

#include <sys/mman.h>

#include <cstdlib>
#include <new>

#include "dataset/model/parallel.h"
#include "dataset/model/scattering.h"

namespace ohb::renderer {
namespace {

uint16_t to_half(float value) {
  return imath_float_to_half(value);
}

/// Not filled. Large pages where the system gives them: less is spent on finding a texel's page.
template <class T>
std::unique_ptr<T[], FreeArray> allocate(size_t count) {
  constexpr size_t kPage = size_t{2} << 20;
  const size_t bytes = (count * sizeof(T) + kPage - 1) / kPage * kPage;
  void* memory = std::aligned_alloc(kPage, bytes);
  if (!memory) throw std::bad_alloc();
  ::madvise(memory, bytes, MADV_HUGEPAGE);
  return std::unique_ptr<T[], FreeArray>(static_cast<T*>(memory));
}

}  // namespace

Texels::Texels(const TextureSet& set)
    : width_px_(set.albedo.width_px),
      height_px_(set.albedo.height_px),
      has_alpha_(!set.alpha.values.empty()) {
  const size_t width = static_cast<size_t>(width_px_), count = width * static_cast<size_t>(height_px_);
  // Not filled with zeros first: whoever writes a page is the first to touch it.
  surface_ = allocate<HalfRecord>(count);
  if (!set.normal.values.empty()) normals_ = allocate<HalfNormal>(count);
  parallel_for_each(0, height_px_, [&](int y) {
    for (size_t i = static_cast<size_t>(y) * width; i < (static_cast<size_t>(y) + 1) * width; ++i) {
      uint16_t* v = surface_[i].values;
      for (size_t c = 0; c < 3; ++c) v[c] = to_half(set.albedo.values[3 * i + c]);
      v[3] = to_half(has_alpha_ ? set.alpha.values[i] : 1.0f);
      for (size_t m = 0; m < 4; ++m) v[4 + m] = 0;
      for (size_t m = 0; m < kMaterialMaps.size(); ++m) {
        const std::vector<float>& values = (set.*kMaterialMaps[m].texels).values;
        if (values.empty()) continue;
        const bool is_sss = kMaterialMaps[m].texels == &TextureSet::sss;
        v[4 + m] = to_half(is_sss ? scattering_of(values[i]) : values[i]);
      }
      if (normals_)
        normals_[i] = {to_half(set.normal.values[3 * i]), to_half(set.normal.values[3 * i + 1]),
                       to_half(set.normal.values[3 * i + 2]), 0};
    }
  });
}

}  // namespace ohb::renderer
