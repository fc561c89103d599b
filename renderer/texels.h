// The maps of a texture set as one interleaved half record a texel: one gather of four texels a hit.
#pragma once

#include <Imath/half.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>

#ifdef __F16C__
#include <immintrin.h>
#endif

#include "dataset/model/map_table.h"

namespace ohb::renderer {

/// What the maps hold at one surface point, filtered.
struct SurfaceTexel {
  Vec3f albedo;     // linear
  float alpha = 1;  // cut-out opacity
  float roughness = 0;
  float specular = 0;  // S, encoded
  float sss = 0;
};

/// Where a SurfaceTexel holds each of kMaterialMaps.
constexpr std::array<float SurfaceTexel::*, kMaterialMaps.size()> kTexelValues = {
    &SurfaceTexel::roughness, &SurfaceTexel::specular, &SurfaceTexel::sss};

struct FreeArray {
  void operator()(void* memory) const { std::free(memory); }
};

/// Bilinear, REPEAT, texel centres at (i + 1/2) / n, no mip-maps: as Cycles filters float images.
class Texels {
 public:
  explicit Texels(const TextureSet& set);

  bool has_alpha() const { return has_alpha_; }
  bool has_normals() const { return normals_ != nullptr; }

  SurfaceTexel surface(Vec2f uv) const {
    const Tap tap = locate(uv);
    float v[8] = {};
    for (int i = 0; i < 4; ++i) accumulate(surface_[tap.index[i]], tap.weight[i], v);
    SurfaceTexel texel{{v[0], v[1], v[2]}, v[3]};
    for (size_t m = 0; m < kTexelValues.size(); ++m) texel.*kTexelValues[m] = v[4 + m];
    return texel;
  }
  float alpha(Vec2f uv) const {
    const Tap tap = locate(uv);
    float alpha = 0;
    for (int i = 0; i < 4; ++i)
      alpha += tap.weight[i] * imath_half_to_float(surface_[tap.index[i]].values[3]);
    return alpha;
  }
  /// Brings what surface() and normal() will read into the cache.
  void prefetch(Vec2f uv) const {
    const Tap tap = locate(uv);
    for (const int corner : {0, 2}) {
      __builtin_prefetch(&surface_[tap.index[corner]]);
      if (has_normals()) __builtin_prefetch(&normals_[tap.index[corner]]);
    }
  }
  /// Tangent-space normal, signed, filtered and not normalised.
  Vec3f normal(Vec2f uv) const {
    const Tap tap = locate(uv);
    Vec3f n{0, 0, 0};
    for (int i = 0; i < 4; ++i) {
      const HalfNormal& t = normals_[tap.index[i]];
      n +=
          tap.weight[i] * Vec3f{imath_half_to_float(t.x), imath_half_to_float(t.y), imath_half_to_float(t.z)};
    }
    return n;
  }

 private:
  struct alignas(16) HalfRecord {
    uint16_t values[8];  // albedo RGB, alpha, kMaterialMaps, unused ones 0
  };
  static_assert(4 + kMaterialMaps.size() <= 8, "a record is one load of eight halves");
  struct HalfNormal {
    uint16_t x, y, z, unused;
  };
  struct Tap {
    size_t index[4];
    float weight[4];
  };

  Tap locate(Vec2f uv) const {
    // The fraction is taken first: UVs far outside [0,1] keep their precision.
    const float x = (uv.x - std::floor(uv.x)) * width_px_ - 0.5f;
    const float y = (1 - (uv.y - std::floor(uv.y))) * height_px_ - 0.5f;
    const float x0f = std::floor(x), y0f = std::floor(y);
    const float fx = x - x0f, fy = y - y0f;
    const size_t x0 = wrap(static_cast<int>(x0f), width_px_), x1 = wrap(static_cast<int>(x0f) + 1, width_px_);
    const size_t y0 = wrap(static_cast<int>(y0f), height_px_),
                 y1 = wrap(static_cast<int>(y0f) + 1, height_px_);
    const size_t row0 = y0 * width_px_, row1 = y1 * width_px_;
    return {{row0 + x0, row0 + x1, row1 + x0, row1 + x1},
            {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
  }
  static size_t wrap(int i, int n) { return static_cast<size_t>(i < 0 ? i + n : i >= n ? i - n : i); }

  static void accumulate(const HalfRecord& record, float weight, float v[8]) {
#ifdef __F16C__
    const __m256 values = _mm256_cvtph_ps(_mm_load_si128(reinterpret_cast<const __m128i*>(record.values)));
    _mm256_storeu_ps(v, _mm256_fmadd_ps(values, _mm256_set1_ps(weight), _mm256_loadu_ps(v)));
#else
    for (int c = 0; c < 8; ++c) v[c] += weight * imath_half_to_float(record.values[c]);
#endif
  }

  int width_px_, height_px_;
  bool has_alpha_;
  std::unique_ptr<HalfRecord[], FreeArray> surface_;
  std::unique_ptr<HalfNormal[], FreeArray> normals_;  // null: no normal map
};

}  // namespace ohb::renderer
