// How much of the light single-scattering GGX reflects: tables that Principled v2 makes up for the rest with
// and that its lower layer is weighted with.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace ohb::renderer {

/// Means over the visible normals of isotropic GGX with height-correlated Smith masking, in a white furnace,
/// by roughness (alpha = roughness^2) and the cosine mu of the viewer. The grids and their linear
/// interpolation are those of Cycles 4.x (32 x 32, and 16 x 16 x 16), which keeps the errors of the
/// interpolation the same; the values are our own integrals.
class GgxEnergy {
 public:
  GgxEnergy();
  /// Directional albedo without Fresnel (Kulla and Conty, "Revisiting Physically Based Shading at
  /// Imageworks", 2017, equation for E(mu)).
  float albedo(float roughness, float mu) const {
    return between(roughness, mu, kFine, kFine, albedo_.data());
  }
  /// The same, averaged over a diffusely lit hemisphere: integral of 2 mu E(mu).
  float mean_albedo(float roughness) const { return along(roughness, kFine, mean_albedo_.data()); }
  /// Where the Fresnel reflectance of a dielectric lies between f0 (0) and 1, on average over the visible
  /// normals whose reflection leaves the surface; its index of refraction is that of reflectance z^4.
  float fresnel_share(float roughness, float mu, float z) const {
    const Cell cell(z, kCoarse);
    const float* slice = fresnel_share_.data() + cell.index * kCoarse * kCoarse;
    const float low = between(roughness, mu, kCoarse, kCoarse, slice);
    const float high = between(roughness, mu, kCoarse, kCoarse, slice + cell.step * kCoarse * kCoarse);
    return low + cell.fraction * (high - low);
  }

  static constexpr int kFine = 32, kCoarse = 16;

 private:
  struct Cell {
    int index, step;
    float fraction;
    Cell(float x, int count) {
      const float position = std::clamp(x, 0.0f, 1.0f) * static_cast<float>(count - 1);
      index = std::min(static_cast<int>(position), count - 1);
      step = index + 1 < count ? 1 : 0;
      fraction = position - static_cast<float>(index);
    }
  };
  static float along(float x, int count, const float* values) {
    const Cell cell(x, count);
    return values[cell.index] + cell.fraction * (values[cell.index + cell.step] - values[cell.index]);
  }
  static float between(float x, float y, int columns, int rows, const float* values) {
    const Cell cell(y, rows);
    const float* row = values + cell.index * columns;
    const float low = along(x, columns, row), high = along(x, columns, row + cell.step * columns);
    return low + cell.fraction * (high - low);
  }

  std::vector<float> albedo_, mean_albedo_, fresnel_share_;
};

/// Made at the first call (about 0.1 s).
const GgxEnergy& ggx_energy();

}  // namespace ohb::renderer
