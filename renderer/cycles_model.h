// What exists only to match Cycles. Each constant or function names the versions it holds for.
#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/eight.h"

namespace ohb::renderer::cycles {

/// Closures whose colour is below this are not made (3.x to 4.x, CLOSURE_WEIGHT_CUTOFF).
constexpr float kClosureWeightCutoff = 1e-5f;
/// GGX narrower than this (alpha squared) is a mirror (3.x to 4.2; from 4.3).
constexpr float kMirrorAlpha2 = 1e-7f, kMirrorAlpha2V2 = 2e-10f;
/// The index of refraction comes from a reflectance of at most this (4.x).
constexpr float kMostF0V2 = 0.99f;
/// Index of refraction of the surface that light enters the medium by (4.x, random walk for skin, its
/// default).
constexpr float kSkinEntryEta = 1.4f;
/// The value that stands for the infinite density of a mirror (3.x).
constexpr float kMirrorDensity = 1e6f;
/// At the first hit each lobe is chosen with at least this share (3.x).
constexpr float kDefensiveShare = 0.125f;
/// Real reflectance at normal incidence = 0.08 x Specular (Principled v1, 3.x).
constexpr float kF0PerSpecular = 0.08f;
/// Bisections of the solver from scattering radius to mean free path (Principled v1, 3.x).
constexpr int kRadiusBisections = 12;
/// Walks under the surface that are not out after so many segments are dropped (all versions so far).
constexpr int kMaxWalkSegments = 256;
/// Walks have at least this single-scattering albedo (3.x).
constexpr float kLeastWalkAlbedo = 0.2f;
/// Subsurface up to this is none (Principled v1, 3.x).
constexpr float kLeastSubsurface = 1e-5f;
/// The lobe that enters the surface is chosen as if it were one lobe a channel (3.x).
constexpr float kSubsurfaceLobeWeight = 3;
/// Environment lookups wrap around the poles as well (all versions so far).
constexpr bool kEnvironmentWrapsPoles = true;

/// The normal, turned towards ng in the plane of both just so far that the mirror direction of wo about it
/// leaves the surface: dot(reflect(wo), ng) >= min(0.9 dot(ng, wo), 0.01). Applied to every lobe (up to 3.5),
/// or to all but the diffuse one (from 3.6).
/// With n' = sin(p) x + cos(p) ng and wo = wx x + wz ng + ..., dot(reflect(wo), ng) = wx sin 2p + wz cos 2p.
inline Vec3f ensure_valid_reflection(Vec3f ng, Vec3f wo, Vec3f n) {
  const float wz = dot(wo, ng);
  const float limit = std::min(0.9f * wz, 0.01f);
  const Vec3f mirror = 2 * dot(n, wo) * n - wo;
  if (dot(mirror, ng) >= limit) return n;
  const float cos_n = dot(n, ng);
  const Vec3f side = n - cos_n * ng;
  const float side_length = length(side);
  if (!(side_length > 1e-6f)) return ng;
  const Vec3f x = side / side_length;
  const float wx = dot(wo, x);
  const float amplitude = std::sqrt(wx * wx + wz * wz);
  if (!(amplitude > 0)) return ng;
  const float middle = std::atan2(wx, wz);
  const float reach = std::acos(std::clamp(limit / amplitude, -1.0f, 1.0f));
  const float angle_n = std::atan2(side_length, cos_n);
  // The mirror condition holds at angle 0 and fails at n: of both roots the larger one below n is the border.
  float best = 0;
  for (const float root : {0.5f * (middle + reach), 0.5f * (middle - reach)})
    if (root > best && root <= angle_n) best = root;
  return std::sin(best) * x + std::cos(best) * ng;
}

/// Softens the terminator of bumped diffuse lobes: factor on the lobe where n differs from the smooth normal
/// ns (up to 4.4; Estevez et al. 2019 in the cubic form of Chiang et al. 2019), of one direction or eight.
template <class T>
T bump_terminator(Vec3f ns, Vec3f n, const typename Lanes<T>::Vec3& wi) {
  const T zero = 0, one = 1, below = dot(n, wi) * dot(ns, n), g = dot(ns, wi) / below;
  const T softened = select(g >= one, one, select(g < zero, zero, g * (1 + g * (1 - g))));
  return select(below != zero, softened, zero);
}

/// The same from 4.5 on (Estevez et al. 2019, equations 3 and 4, with the angle to ns): masking of GGX as
/// wide as the normal is tilted.
template <class T>
T bump_terminator_v2(Vec3f ns, Vec3f n, const typename Lanes<T>::Vec3& wi) {
  using std::sqrt, std::abs;
  using Mask = typename Lanes<T>::Mask;
  const T zero = 0, one = 1, c = dot(ns, wi), size = abs(c);
  const float cos_tilt = dot(ns, n);
  const float alpha2 = std::clamp(0.125f * (1 / (cos_tilt * cos_tilt) - 1), 0.0f, 1.0f);
  T factor = 2 / (1 + sqrt(1 + alpha2 * (1 / (c * c) - 1)));
  factor = select(size < T(1e-6f), zero, factor);
  factor = select(Mask(std::fabs(cos_tilt) >= 1) || size >= one, one, factor);
  return select(c * cos_tilt * dot(n, wi) < zero, zero, factor);
}

}  // namespace ohb::renderer::cycles
