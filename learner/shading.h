// The Disney (Burley 2012) reflection of one point light at one pixel, with its derivatives: the one place
// that holds the formulas of the training shader. Per pixel and light, templates over float and double, so
// that the fused loss can run it in vector registers and tests can run it in double.
//
// Frame: orthographic, the frame's width is [-1, 1]; +X right, +Y up, +Z to the viewer; the viewer is at
// (0, 0, 1). Lengths (displacement, light positions) are in halves of the frame's width.
// Sources: Burley, "Physically-Based Shading at Disney" (2012) for diffuse, subsurface and Fresnel; Smith
// masking with alpha = roughness^2 (2014 on, as in Blender); t = 1 + (a^2 - 1) NH^2 is written by Lagrange's
// identity as a^2 NH^2 + |n x h|^2, which keeps 100 to 5000 times more digits where NH is near 1.
#pragma once

#include <array>
#include <cmath>
#include <string_view>

namespace ohb::learner::shading {

constexpr double kPi = 3.14159265358979323846;
/// The maps that the shader reads, and their names in kMaps (learner/maps.h).
enum Plane { kNormal, kDiffuse, kRoughness, kSpecular, kSss, kDisplacement, kPlaneCount };
constexpr std::array<std::string_view, kPlaneCount> kPlaneNames = {"normal",   "diffuse", "roughness",
                                                                   "specular", "sss",     "displacement"};

/// Cosines at or below this are not lit; also the floor of denominators.
constexpr double kMinCosine = 1e-4;
/// Floor of NL + NV in the subsurface lobe, which has 1 / (NL + NV).
constexpr double kMinCosineSum = 0.02;

/// Position in the frame's units and intensity: irradiance at distance 1, the same in R, G, B.
template <typename T>
struct Light {
  T x, y, z, intensity;
};

/// What one pixel reflects with. `normal` is of unit length, roughness is perceptual and above 0, f0 is the
/// linear reflectance at normal incidence, diffuse is linear.
template <typename T>
struct Surface {
  T u, v, z;     // position
  T nx, ny, nz;  // normal
  T d0, d1, d2;  // diffuse albedo
  T roughness, f0, sss;
};

/// Gradient of a scalar with respect to a Surface. The normal's part is along the tangent plane and radially
/// arbitrary: project it (I - n n^T) before use.
template <typename T>
struct SurfaceGradient {
  T nx, ny, nz, z, d0, d1, d2, roughness, f0, sss;
};

/// Everything that reflect_backward needs of reflect.
template <typename T>
struct Reflection {
  T out0, out1, out2;  // reflected radiance
  bool lit;
  T inv_distance, lx, ly, lz, irradiance, inv_half, nl, nv, nh, lh, a2, s2, t, d, ql, qv, gl, gv, wl, wv, wh,
      f, fs, fd90, fdl, fdv, fss90, fsl, fsv, inv_sum, inv_sum_slope, ss, kd;
};

/// x, but at least `floor`. NaN stays NaN, so that guards can see it.
template <typename T>
[[gnu::always_inline]] inline T at_least(T x, T floor) {
  return x < floor ? floor : x;
}

template <typename T>
[[gnu::always_inline]] inline T power5(T x) {
  const T x2 = x * x;
  return x2 * x2 * x;
}

/// Directions, cosines and irradiance: the part of reflect that depends on the geometry alone.
template <typename T>
[[gnu::always_inline]] inline void set_geometry(Reflection<T>& r, const Surface<T>& s,
                                                const Light<T>& light) {
  const T x = light.x - s.u, y = light.y - s.v, z = light.z - s.z;
  const T squared = at_least(x * x + y * y + z * z, T(kMinCosine));
  r.inv_distance = T(1) / std::sqrt(squared);
  r.irradiance = light.intensity / squared;
  r.lx = x * r.inv_distance;
  r.ly = y * r.inv_distance;
  r.lz = z * r.inv_distance;
  // |l + v|^2 = 2 + 2 lz since both are of unit length.
  r.inv_half = T(1) / std::sqrt(at_least(T(2) + T(2) * r.lz, T(1e-8)));
  const T nl = s.nx * r.lx + s.ny * r.ly + s.nz * r.lz;
  r.lit = !(nl <= T(kMinCosine)) & !(s.nz <= T(kMinCosine));
  r.nl = at_least(nl, T(kMinCosine));
  r.nv = at_least(s.nz, T(kMinCosine));
  r.nh = (nl + s.nz) * r.inv_half;
  r.lh = (T(1) + r.lz) * r.inv_half;
}

template <typename T>
[[gnu::always_inline]] inline void set_specular(Reflection<T>& r, const Surface<T>& s) {
  const T hx = r.lx * r.inv_half, hy = r.ly * r.inv_half, hz = (r.lz + T(1)) * r.inv_half;
  const T cx = s.ny * hz - s.nz * hy, cy = s.nz * hx - s.nx * hz, cz = s.nx * hy - s.ny * hx;
  const T r2 = s.roughness * s.roughness;
  r.a2 = r2 * r2;
  r.s2 = cx * cx + cy * cy + cz * cz;
  r.t = at_least(r.a2 * r.nh * r.nh + r.s2, T(1e-12));
  r.d = r.a2 / (T(kPi) * r.t * r.t);
  r.ql = std::sqrt(r.a2 + (T(1) - r.a2) * r.nl * r.nl);
  r.qv = std::sqrt(r.a2 + (T(1) - r.a2) * r.nv * r.nv);
  // Smith masking over 2 c: 1 / (c + sqrt(a^2 + c^2 - a^2 c^2)).
  r.gl = T(1) / (r.nl + r.ql);
  r.gv = T(1) / (r.nv + r.qv);
  r.wh = power5(T(1) - r.lh);
  r.f = s.f0 + (T(1) - s.f0) * r.wh;
  r.fs = r.d * r.gl * r.gv * r.f;
}

template <typename T>
[[gnu::always_inline]] inline void set_diffuse(Reflection<T>& r, const Surface<T>& s) {
  r.wl = power5(T(1) - r.nl);
  r.wv = power5(T(1) - r.nv);
  r.fss90 = s.roughness * r.lh * r.lh;
  r.fd90 = T(0.5) + T(2) * r.fss90;
  r.fdl = T(1) + (r.fd90 - T(1)) * r.wl;
  r.fdv = T(1) + (r.fd90 - T(1)) * r.wv;
  r.fsl = T(1) + (r.fss90 - T(1)) * r.wl;
  r.fsv = T(1) + (r.fss90 - T(1)) * r.wv;
  const T sum = r.nl + r.nv;
  const bool floored = sum < T(kMinCosineSum);
  r.inv_sum = T(1) / (floored ? T(kMinCosineSum) : sum);
  r.inv_sum_slope = floored ? T(0) : -r.inv_sum * r.inv_sum;
  r.ss = T(1.25) * (r.fsl * r.fsv * (r.inv_sum - T(0.5)) + T(0.5));
  r.kd = (T(1) - s.sss) * r.fdl * r.fdv + s.sss * r.ss;
}

/// Radiance towards the viewer: [diffuse / pi ((1 - sss) Fd + sss ss) + D G F] NL E. 0 where the light or the
/// viewer is behind the surface.
template <typename T>
[[gnu::always_inline]] inline Reflection<T> reflect(const Surface<T>& s, const Light<T>& light) {
  Reflection<T> r;
  set_geometry(r, s, light);
  set_specular(r, s);
  set_diffuse(r, s);
  const T k = r.nl * r.irradiance, kd = r.kd * T(1 / kPi);
  r.out0 = r.lit ? (s.d0 * kd + r.fs) * k : T(0);
  r.out1 = r.lit ? (s.d1 * kd + r.fs) * k : T(0);
  r.out2 = r.lit ? (s.d2 * kd + r.fs) * k : T(0);
  return r;
}

/// The gradient of a scalar whose gradient with respect to reflect()'s output is (g0, g1, g2).
template <typename T>
[[gnu::always_inline]] inline SurfaceGradient<T> reflect_backward(const Surface<T>& s, const Reflection<T>& r,
                                                                  T g0, T g1, T g2) {
  const T k = r.nl * r.irradiance;
  const T a = (g0 * s.d0 + g1 * s.d1 + g2 * s.d2) * T(1 / kPi), b = g0 + g1 + g2;
  const T dkd = a * k, dfs = b * k, reflected = a * r.kd + b * r.fs;
  const T dirradiance = reflected * r.nl;
  const T one_l = T(1) - r.nl, one_v = T(1) - r.nv, one_h = T(1) - r.lh;
  const T wl_slope = T(-5) * one_l * one_l * one_l * one_l, wv_slope = T(-5) * one_v * one_v * one_v * one_v,
          wh_slope = T(-5) * one_h * one_h * one_h * one_h;

  // Diffuse and subsurface.
  const T dfd = dkd * (T(1) - s.sss), dss = dkd * s.sss * T(1.25);
  const T dfss = dss * (r.inv_sum - T(0.5)), dsum = dss * r.fsl * r.fsv * r.inv_sum_slope;
  const T dfd90 = dfd * (r.wl * r.fdv + r.wv * r.fdl), dfss90 = dfss * (r.wl * r.fsv + r.wv * r.fsl);
  const T dwl = dfd * (r.fd90 - T(1)) * r.fdv + dfss * (r.fss90 - T(1)) * r.fsv;
  const T dwv = dfd * (r.fd90 - T(1)) * r.fdl + dfss * (r.fss90 - T(1)) * r.fsl;
  const T dretro = T(2) * dfd90 + dfss90;  // of roughness LH^2

  // Specular.
  const T gg = r.gl * r.gv, df = dfs * r.d * gg, dd = dfs * gg * r.f, dg = dfs * r.d * r.f;
  const T inv_t3 = T(1) / (T(kPi) * r.t * r.t * r.t);
  const T dnh = dd * T(4) * r.a2 * (T(1) - r.a2) * r.nh * inv_t3;
  const T dgl = -dg * r.gv * r.gl * r.gl, dgv = -dg * r.gl * r.gv * r.gv;
  const T da2 = dd * (r.s2 - r.a2 * r.nh * r.nh) * inv_t3 + dgl * (T(1) - r.nl * r.nl) / (T(2) * r.ql) +
                dgv * (T(1) - r.nv * r.nv) / (T(2) * r.qv);

  const T dnl = reflected * r.irradiance + dwl * wl_slope + dsum + dgl * (T(1) + r.nl * (T(1) - r.a2) / r.ql);
  const T dnv = dwv * wv_slope + dsum + dgv * (T(1) + r.nv * (T(1) - r.a2) / r.qv);
  const T dlh = T(2) * s.roughness * r.lh * dretro + df * (T(1) - s.f0) * wh_slope;

  // Through the half vector to the light's direction: (I - h h^T)(dnh n) / |l + v|; LH^2 = (1 + lz) / 2.
  const T hx = r.lx * r.inv_half, hy = r.ly * r.inv_half, hz = (r.lz + T(1)) * r.inv_half;
  const T through_half = dnh * r.inv_half;
  const T dlx = dnl * s.nx + through_half * (s.nx - r.nh * hx);
  const T dly = dnl * s.ny + through_half * (s.ny - r.nh * hy);
  const T dlz = dnl * s.nz + through_half * (s.nz - r.nh * hz) + dlh / (T(4) * at_least(r.lh, T(kMinCosine)));
  const T radial = r.lx * dlx + r.ly * dly + r.lz * dlz;

  const T on = r.lit ? T(1) : T(0);
  SurfaceGradient<T> g;
  g.nx = r.lit ? dnl * r.lx + dnh * hx : T(0);
  g.ny = r.lit ? dnl * r.ly + dnh * hy : T(0);
  g.nz = r.lit ? dnl * r.lz + dnh * hz + dnv : T(0);
  g.z = r.lit ? (T(2) * dirradiance * r.irradiance * r.lz - (dlz - radial * r.lz)) * r.inv_distance : T(0);
  const T albedo = on * r.kd * k * T(1 / kPi);
  g.d0 = g0 * albedo;
  g.d1 = g1 * albedo;
  g.d2 = g2 * albedo;
  g.roughness = r.lit ? r.lh * r.lh * dretro + da2 * T(4) * s.roughness * s.roughness * s.roughness : T(0);
  g.f0 = r.lit ? df * (T(1) - r.wh) : T(0);
  g.sss = r.lit ? dkd * (r.ss - r.fdl * r.fdv) : T(0);
  return g;
}

}  // namespace ohb::learner::shading
