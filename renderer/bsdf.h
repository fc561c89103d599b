// Principled v1 of Blender 3.4: Disney diffuse and single-scatter GGX, added without layering.
// Directions point away from the surface; n is the shading normal, ns the smooth normal, ng the geometric
// one, all on the side of wo. eval() returns f times the cosine; pdfs are in solid angle.
// Formulas: Burley, "Physically-Based Shading at Disney", 2012 (diffuse); Walter et al. 2007 (GGX, dielectric
// Fresnel); constants and order of operations measured against Cycles 3.4.1 (tests/renderer).
#pragma once

#include "dataset/model/sampling.h"
#include "renderer/cycles_model.h"
#include "renderer/eight.h"

namespace ohb::renderer {

// Formulas are written once, over T: float, or eight of them (eight.h).

/// (1 - x)^5 with x clamped to [0, 1] (Schlick's weight).
template <class T>
T schlick_weight(T x) {
  const T zero = 0, one = 1, m = smaller(one, larger(zero, 1 - x));
  return (m * m) * (m * m) * m;
}

/// Exact unpolarised Fresnel reflectance from outside at cosine c of relative index eta >= 1.
template <class T>
T fresnel_dielectric(T c, float eta) {
  using std::abs, std::sqrt;
  const T zero = 0, one = 1;
  c = abs(c);
  const T g2 = eta * eta - 1 + c * c, g = sqrt(larger(zero, g2));
  const T a = (g - c) / (g + c), b = (c * (g + c) - 1) / (c * (g - c) + 1);
  return select(g2 > zero, 0.5f * a * a * (1 + b * b), one);
}

/// Relative index of refraction whose normal-incidence reflectance is f0 in [0, 1).
inline float eta_of_f0(float f0) {
  return 2 / (1 - std::sqrt(std::min(f0, 0.9999f))) - 1;
}

/// Smith's masking of one direction with cosine c for isotropic GGX.
template <class T>
T ggx_g1(T c, float alpha2) {
  using std::sqrt;
  const T zero = 0, c2 = c * c;
  return 2 / (1 + sqrt(1 + alpha2 * larger(zero, 1 - c2) / c2));
}

inline Vec3f halfway(Vec3f wo, Vec3f wi) {
  return normalised(wi + wo);
}
inline Vec3f8 halfway(Vec3f wo, const Vec3f8& wi) {
  const Vec3f8 sum{wi.x + wo.x, wi.y + wo.y, wi.z + wo.z};
  const Float8 scale = 1 / sqrt(dot(sum, sum));
  return {scale * sum.x, scale * sum.y, scale * sum.z};
}

/// GGX's density of the facet normal between wo and wi over 4 (n.wo): what the highlight and its pdf share.
/// Zero where the facet is turned away.
template <class T>
struct Facet {
  T cos_i_h, density;
  Facet(Vec3f n, Vec3f wo, const typename Lanes<T>::Vec3& wi, float alpha2) {
    const auto h = halfway(wo, wi);
    const T zero = 0, cos_h = dot(n, h);
    // 1 - cos^2 as |n x h|^2 (Lagrange's identity): the difference would cancel at small roughness.
    const auto sine = cross(n, h);
    const T t = alpha2 * cos_h * cos_h + dot(sine, sine);
    cos_i_h = dot(wi, h);
    density = select(cos_h > zero, alpha2 * kInvPi / (4 * dot(n, wo)) / (t * t), zero);
  }
};

/// What light does that is not mirrored at the surface.
enum class DiffuseLobe {
  kWhole,            // Burley's diffuse
  kRetroReflection,  // the part of it that stays at the surface where the rest walks under it
  kExit              // the end of a walk: white, of the leaving direction alone
};

struct BsdfSample {
  Vec3f wi;
  Vec3f value;              // f times cosine of all lobes
  float pdf = 0;            // of the mixture; 0: no direction
  bool enters = false;      // the path goes under the surface: no direction, `pdf` is the chance of it
  bool is_diffuse = false;  // of the lobe that was chosen
  /// eval() refuses the highlight in this direction: only sampling brings it, with the weight of the power
  /// heuristic between single directions that Cycles gives it.
  bool is_hidden_highlight = false;
};

/// f times the cosine, and the mixture's pdf, of one direction or of eight.
template <class T>
struct BsdfValueOf {
  typename Lanes<T>::Vec3 value{};
  T pdf = 0;
};
using BsdfValue = BsdfValueOf<float>;
using BsdfValue8 = BsdfValueOf<Float8>;

/// Numbers that eight directions are drawn with.
struct Numbers8 {
  Float8 u0, x, y, height;  // choice of lobe; sample_disk(), and what is left of 1 above it

  Numbers8(int count, const float* choice, const Vec2f* u) {
    const auto lanes = [&](auto value) {
      return Float8([&](auto k) { return int{k} < count ? value(int{k}) : 0.0f; });
    };
    u0 = lanes([&](int k) { return choice[k]; });
    const Float8 zero = 0, u1 = lanes([&](int k) { return u[k].x; }), radius = sqrt(u1);
    sine_cosine_of_turns(lanes([&](int k) { return u[k].y; }), y, x);
    x *= radius, y *= radius;
    height = sqrt(stdx::max(zero, 1 - u1));
  }
  /// sample_cosine_hemisphere
  Vec3f8 cosine_hemisphere() const { return {x, y, height}; }
  /// wo mirrored by facets, which sample_ggx_visible_normal draws.
  Vec3f8 mirrored_by_facets(const Frame& frame, Vec3f wo, float alpha) const {
    const Float8 zero = 0;
    const GgxView view(frame.to_local(wo), alpha);
    const Float8 y_seen = (1 - view.blend) * sqrt(stdx::max(zero, 1 - x * x)) + view.blend * y;
    const Float8 z = sqrt(stdx::max(zero, 1 - x * x - y_seen * y_seen));
    const auto along = [&](int axis) {
      return x * view.t1[axis] + y_seen * view.t2[axis] + z * view.v[axis];
    };
    const Vec3f8 local{alpha * along(0), alpha * along(1), stdx::max(Float8(1e-6f), along(2))};
    const Float8 scale = 1 / sqrt(dot(local, local));
    const Vec3f8 h = to_world(frame, {scale * local.x, scale * local.y, scale * local.z});
    const Float8 twice = 2 * dot(wo, h);
    return {twice * h.x - wo.x, twice * h.y - wo.y, twice * h.z - wo.z};
  }
};

/// Eight directions as they were drawn.
struct Drawn8 {
  Vec3f8 wi;
  BsdfValue8 f;
  Mask8 enters, is_diffuse, is_hidden_highlight;
  float entry_share;

  /// The first `count` of them.
  void store(int count, BsdfSample* samples) const {
    for (int k = 0; k < count; ++k) {
      samples[k] = {};
      samples[k].enters = enters[k];
      samples[k].pdf = entry_share;
      if (enters[k]) continue;
      samples[k] = {{wi.x[k], wi.y[k], wi.z[k]},
                    {f.value.x[k], f.value.y[k], f.value.z[k]},
                    f.pdf[k],
                    false,
                    is_diffuse[k],
                    is_hidden_highlight[k]};
    }
  }
};

/// What a surface reflects: linear albedo, perceptual roughness, reflectance at normal incidence.
struct Reflectance {
  Vec3f base;
  float roughness, f0;
};

/// Unit normals on the side of wo: the shading normal (made valid, cycles::ensure_valid_reflection), the
/// smooth and the geometric one.
struct ShadingFrame {
  Vec3f n, ns, ng, wo;
};

/// From roughness 0.3 on a highlight is wide enough to be found by the lights' own directions.
constexpr float kRoughAlpha2 = 0.0081f;

class PrincipledV1 {
 public:
  /// `first_hit` turns on the defensive choice of lobes. kRetroReflection adds the lobe that enters the
  /// surface, of weight base.
  PrincipledV1(const Reflectance& surface, const ShadingFrame& frame, bool first_hit,
               DiffuseLobe lobe = DiffuseLobe::kWhole)
      : base_(surface.base),
        n_(frame.n),
        ns_(frame.ns),
        ng_(frame.ng),
        wo_(frame.wo),
        roughness_(surface.roughness),
        cos_o_(dot(frame.n, frame.wo)),
        lobe_(lobe) {
    const float alpha = roughness_ * roughness_;
    alpha2_ = alpha * alpha;
    eta_ = eta_of_f0(std::min(surface.f0, 1.0f));
    bumped_ = n_.x != ns_.x || n_.y != ns_.y || n_.z != ns_.z;
    has_diffuse_ = max_component(base_) > cycles::kClosureWeightCutoff;
    has_specular_ = surface.f0 > cycles::kClosureWeightCutoff * cycles::kF0PerSpecular && cos_o_ > 0;
    choose_lobes(first_hit);
  }

  /// f cos and the mixture's pdf for a given direction, or eight; a mirror lobe counts as 0.
  BsdfValue eval(Vec3f wi) const { return eval_seen<float>(wi); }
  BsdfValue8 eval(const Vec3f8& wi) const { return eval_seen<Float8>(wi); }

  /// A direction of the mixture. u0 chooses the lobe.
  BsdfSample sample(float u0, float u1, float u2) const {
    BsdfSample result;
    if (u0 < entry_share_) {
      result.enters = true;
      result.pdf = entry_share_;
      return result;
    }
    const bool specular_chosen = has_specular_ && !(has_diffuse_ && u0 < entry_share_ + diffuse_share_);
    if (has_diffuse_ && !specular_chosen) {
      result.is_diffuse = true;
      result.wi = Frame(n_).to_world(sample_cosine_hemisphere(u1, u2));
    } else if (specular_chosen) {
      if (alpha2_ <= cycles::kMirrorAlpha2) return sample_mirror();
      const Frame frame(n_);
      const Vec3f h = sample_ggx_visible_normal(frame.to_local(wo_), std::sqrt(alpha2_), u1, u2);
      const Vec3f h_world = frame.to_world(h);
      result.wi = 2 * dot(h_world, wo_) * h_world - wo_;
    } else {
      return result;
    }
    if (!(dot(ng_, result.wi) > 0)) return result;
    // The highlight that was sampled keeps directions below the smooth surface (and below n) as long as they
    // are above the geometric one, though eval() refuses them: such light counts with the weight that BSDF
    // sampling has (3.4; measured: 1.2 % of the highlights of a ball with normals tilted up to 35 degrees).
    const float cos_i = dot(n_, result.wi);
    const BsdfValue value =
        specular_chosen ? eval_lobes<float>(result.wi, cos_i, cos_i > 0, true) : eval(result.wi);
    result.value = value.value;
    result.pdf = value.pdf;
    result.is_hidden_highlight = specular_chosen && !(dot(n_, result.wi) > 0 && dot(ns_, result.wi) > 0);
    return result;
  }

  /// sample() of up to eight numbers: those of the lobes, and of the directions.
  void sample(int count, const float* u0, const Vec2f* u, BsdfSample* samples) const {
    if (has_specular_ && alpha2_ <= cycles::kMirrorAlpha2) {
      for (int k = 0; k < count; ++k) samples[k] = sample(u0[k], u[k].x, u[k].y);
      return;
    }
    const Numbers8 numbers(count, u0, u);
    const Float8 zero = 0;
    const Mask8 enters = numbers.u0 < Float8(entry_share_), has_highlight(has_specular_),
                has_diffuse(has_diffuse_),
                is_specular = has_highlight && !enters &&
                              !(has_diffuse && numbers.u0 < Float8(entry_share_ + diffuse_share_)),
                is_diffuse = has_diffuse && !enters && !is_specular;
    const Frame frame(n_);
    Vec3f8 wi = to_world(frame, numbers.cosine_hemisphere());
    if (stdx::any_of(is_specular))
      wi = select(is_specular, numbers.mirrored_by_facets(frame, wo_, std::sqrt(alpha2_)), wi);
    const Float8 cos_i = dot(n_, wi);
    const Mask8 is_above = cos_i > zero, is_seen = is_above && dot(ns_, wi) > zero;
    BsdfValue8 f = eval_lobes<Float8>(wi, cos_i, is_above, is_seen || is_specular);
    f.pdf = select(dot(ng_, wi) > zero && (is_specular || is_diffuse), f.pdf, zero);
    Drawn8{wi, f, enters, is_diffuse, is_specular && !is_seen, entry_share_}.store(count, samples);
  }

  /// No lobe is too narrow to be left to the lights' own directions.
  bool is_rough() const { return !has_specular_ || alpha2_ >= kRoughAlpha2; }
  bool is_black() const { return !has_diffuse_ && !has_specular_; }

  /// Factor on what enters the medium, which has the colour.
  float entry_weight() const { return 1; }
  /// The normal that walks are guided along.
  Vec3f entry_axis() const { return n_; }
  /// Cosine about -n.
  Vec3f entry_direction(Vec2f u) const { return Frame(-n_).to_world(sample_cosine_hemisphere(u.x, u.y)); }

 private:
  // Cycles' sample weights: mean albedo against the Fresnel reflectance towards the viewer.
  void choose_lobes(bool first_hit) {
    const bool enters = has_diffuse_ && lobe_ == DiffuseLobe::kRetroReflection;
    float diffuse_weight = has_diffuse_ ? mean(base_) : 0;
    float entry_weight = 0;
    if (enters) {
      entry_weight = cycles::kSubsurfaceLobeWeight * diffuse_weight;
      diffuse_weight *= roughness_ * schlick_weight(cos_o_);
    }
    float specular_weight = has_specular_ ? fresnel(cos_o_) : 0;
    const float sum = diffuse_weight + specular_weight + entry_weight;
    if (first_hit) {
      const float least = cycles::kDefensiveShare * sum;
      if (has_diffuse_) diffuse_weight = std::max(diffuse_weight, least);
      if (has_specular_) specular_weight = std::max(specular_weight, least);
      if (enters) entry_weight = std::max(entry_weight, least);
    }
    const float total = diffuse_weight + specular_weight + entry_weight;
    diffuse_share_ = total > 0 ? diffuse_weight / total : 0;
    entry_share_ = total > 0 ? entry_weight / total : 0;
  }

  // F0 is scalar, so the blend of Cycles' principled Fresnel from F0 to 1 is the dielectric curve itself.
  float fresnel(float c) const { return fresnel_dielectric(c, eta_); }

  // Burley's diffuse lobe over base_, for directions above n_.
  template <class T>
  T diffuse(const typename Lanes<T>::Vec3& wi, T cos_i) const {
    const T wl = schlick_weight(cos_i);
    const float wv = schlick_weight(cos_o_);
    T value = 0;
    if (lobe_ == DiffuseLobe::kWhole) value = (1 - 0.5f * wv) * (1 - 0.5f * wl);
    if (lobe_ == DiffuseLobe::kExit) value = 1 - 0.5f * wl;
    if (lobe_ != DiffuseLobe::kExit) {
      const T retro = roughness_ * (dot(wo_, wi) + 1);
      value += retro * (wl + wv + wl * wv * (retro - 1));
    }
    value *= cos_i * kInvPi;
    return bumped_ ? value * cycles::bump_terminator<T>(ns_, n_, wi) : value;
  }

  // Diffuse light of the directions that are `above`, highlights where they `shine`.
  template <class T>
  BsdfValueOf<T> eval_lobes(const typename Lanes<T>::Vec3& wi, T cos_i, typename Lanes<T>::Mask above,
                            typename Lanes<T>::Mask shine) const {
    const T zero = 0;
    T below = 0, specular = 0, pdf = 0;
    if (has_diffuse_ && any_of(above)) {
      below = select(above, diffuse<T>(wi, cos_i), zero);
      pdf = select(above, diffuse_share_ * kInvPi * cos_i, zero);
    }
    if (has_specular_ && alpha2_ > cycles::kMirrorAlpha2 && any_of(shine)) {
      const Facet<T> facet(n_, wo_, wi, alpha2_);
      const T common = ggx_g1(cos_o_, alpha2_) * facet.density;
      specular =
          select(shine, fresnel_dielectric(facet.cos_i_h, eta_) * common * ggx_g1(cos_i, alpha2_), zero);
      pdf += select(shine, specular_share() * common, zero);
    }
    return {{base_.x * below + specular, base_.y * below + specular, base_.z * below + specular}, pdf};
  }

  // Light below the smooth surface must not make highlights through a tilted normal (3.4.1).
  template <class T>
  BsdfValueOf<T> eval_seen(const typename Lanes<T>::Vec3& wi) const {
    const T zero = 0, cos_i = dot(n_, wi);
    const typename Lanes<T>::Mask is_above = cos_i > zero;
    return eval_lobes<T>(wi, cos_i, is_above, is_above && dot(ns_, wi) > zero);
  }

  BsdfSample sample_mirror() const {
    BsdfSample result;
    result.wi = 2 * cos_o_ * n_ - wo_;
    if (!(dot(ng_, result.wi) > 0)) return result;
    const BsdfValue rest = eval(result.wi);
    const float value = fresnel(cos_o_) * cycles::kMirrorDensity;
    result.value = rest.value + Vec3f{value, value, value};
    result.pdf = rest.pdf + specular_share() * cycles::kMirrorDensity;
    return result;
  }

  float specular_share() const { return 1 - diffuse_share_ - entry_share_; }

  Vec3f base_, n_, ns_, ng_, wo_;
  float roughness_, cos_o_, alpha2_, eta_, diffuse_share_, entry_share_;
  DiffuseLobe lobe_;
  bool bumped_, has_diffuse_, has_specular_;
};

}  // namespace ohb::renderer
