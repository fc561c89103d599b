#include "renderer/subsurface.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ohb::renderer {
namespace {

// Diffuse Fresnel reflectance at relative index 1.4 (Egan and Hilgeman's fit, as in Jensen 2001) and from it
// 4/3 A.
float four_thirds_a() {
  constexpr float kEta = 1.4f;
  const float fdr = -1.440f / (kEta * kEta) + 0.710f / kEta + 0.668f + 0.0636f * kEta;
  return 4.0f / 3.0f * (1 + fdr) / (1 - fdr);
}

float dipole_reflectance(float reduced_albedo, float four_thirds) {
  const float s = std::sqrt(std::max(0.0f, 3 * (1 - reduced_albedo)));
  return 0.5f * reduced_albedo * (1 + std::exp(-four_thirds * s)) * std::exp(-s);
}

// Node i of the tree of all bisections: its midpoint's reflectance. The children of i are 2 i (below) and
// 2 i + 1 (above), so a search makes the same twelve comparisons without their exponentials.
using BisectionTree = std::array<float, 1u << cycles::kRadiusBisections>;

BisectionTree bisection_tree() {
  BisectionTree tree{};
  const float four_thirds = four_thirds_a();
  for (uint32_t node = 1; node < tree.size(); ++node) {
    int depth = 31 - __builtin_clz(node);
    const float step = std::ldexp(1.0f, -(depth + 1));
    const float midpoint = step * static_cast<float>(2 * (node - (1u << depth)) + 1);
    tree[node] = dipole_reflectance(midpoint, four_thirds);
  }
  return tree;
}

float reduced_albedo(float colour) {
  static const BisectionTree tree = bisection_tree();
  if (colour < 1e-4f) return 0;
  if (colour >= 0.995f) return 0.999999f;
  uint32_t node = 1, last = 1;
  for (int i = 0; i < cycles::kRadiusBisections; ++i) {
    last = node;
    node = 2 * node + (tree[node] < colour ? 1 : 0);
  }
  const uint32_t first_of_depth = 1u << (cycles::kRadiusBisections - 1);
  return std::ldexp(static_cast<float>(2 * (last - first_of_depth) + 1), -cycles::kRadiusBisections);
}

}  // namespace

float mean_free_path_a_radius(float colour) {
  return std::sqrt(3 * (1 - reduced_albedo(colour)));
}

float single_scattering_albedo(float colour) {
  const float a = std::max(0.0f, colour);
  const float blend = std::sqrt(std::sqrt(a));
  const float albedo = (1 - blend) * 1.8260524f * std::pow(std::atan(5.1124679f * a), 1.0968610f) +
                       blend * 0.4963102f * std::pow(std::atan(4.2350090f * a), 2.4060300f);
  return std::clamp(albedo, 0.0f, 0.999999f);
}

float relaxation_length_mfp(float albedo) {
  const float p = std::pow(albedo, 2.44294f - 0.0215813f * albedo + 0.578637f / albedo);
  return 1 / std::sqrt(std::max(1e-7f, 1 - p));
}

SubsurfaceMedium subsurface_medium(Vec3f colour, Vec3f radius_cm) {
  SubsurfaceMedium medium{};
  for (int c = 0; c < 3; ++c) {
    const float mfp_cm = radius_cm[c] * mean_free_path_a_radius(colour[c]);
    medium.sigma_t_per_cm[c] = 1 / std::max(mfp_cm, 1e-16f);
    const float albedo = single_scattering_albedo(colour[c]);
    // A dark medium would scatter so rarely that walks end at once: the walk is given an albedo of at least
    // this, and carries less.
    medium.albedo[c] = std::max(albedo, cycles::kLeastWalkAlbedo);
    medium.entry_weight[c] = colour[c] > 0 ? std::min(1.0f, albedo / cycles::kLeastWalkAlbedo) : 0.0f;
    medium.relaxation_mfp[c] = std::max(1.0001f, relaxation_length_mfp(medium.albedo[c]));
  }
  return medium;
}

}  // namespace ohb::renderer
