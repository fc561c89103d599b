// Principled v2 of Blender 4.5: a dielectric layer of GGX that accounts for several bounces between its
// facets, over Lambert or a medium below, which get what the layer does not reflect.
// Directions and conventions are those of bsdf.h. Two shading normals: n as mapped, for the diffuse lobe, and
// n_valid (cycles::ensure_valid_reflection), for the layer and for what enters the medium.
// Formulas: Walter et al. 2007 and Heitz 2014 (GGX, height-correlated masking); Turquin, "Practical multiple
// scattering compensation for microfacet models", 2019, and Kulla and Conty 2017 (energy); Belcour et al.
// 2018 (a layer's weight by its albedo); Estevez et al. 2019 (bump terminator). Constants, tables and order
// of operations as in Cycles 4.5, measured against it (tests/renderer/cycles_ladder_v2_test.cpp).
#pragma once

#include "renderer/bsdf.h"
#include "renderer/ggx_energy.h"

namespace ohb::renderer {

/// Lambda of Smith's masking for isotropic GGX: G1 = 1 / (1 + lambda).
template <class T>
T ggx_lambda(T c, float alpha2) {
  using std::sqrt;
  const T zero = 0;
  return 0.5f * (sqrt(1 + alpha2 * larger(zero, 1 / (c * c) - 1)) - 1);
}

class PrincipledV2 {
 public:
  /// How much of the light below the layer goes into the medium, and whether it walks there or (after a
  /// diffuse bounce) leaves at once, as from a diffuse surface about n_valid.
  struct Subsurface {
    float weight = 0;
    bool walks = false;
  };

  /// `frame` holds the mapped normal as n, `n_valid` its valid form.
  PrincipledV2(const Reflectance& surface, Subsurface subsurface, const ShadingFrame& frame, Vec3f n_valid,
               bool first_hit)
      : n_(frame.n),
        n_valid_(n_valid),
        ns_(frame.ns),
        ng_(frame.ng),
        wo_(frame.wo),
        cos_o_(dot(n_valid, frame.wo)) {
    const float roughness = surface.roughness, f0 = surface.f0;
    const Vec3f base = surface.base;
    const float alpha = roughness * roughness;
    alpha2_ = alpha * alpha;
    float specular_weight = 0, below = 1;
    if (f0 > 0) {
      const float layer_albedo = set_up_layer(roughness, f0);
      below = std::clamp(1 - layer_albedo, 0.0f, 1.0f);
      if (cos_o_ > 0) specular_weight = layer_albedo;
    }
    const float scattered = subsurface.weight * below;
    diffuse_ = (below - scattered) * base;
    entry_weight_ = subsurface.walks ? scattered : 0;
    if (!subsurface.walks) medium_ = scattered * min_one(base);
    choose_lobes(specular_weight, mean(base), first_hit);
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
    u0 -= entry_share_;
    const float below_share = diffuse_share_ + medium_share_;
    if (below_share > 0 && (u0 < below_share || !(specular_share_ > 0))) {
      result.is_diffuse = true;
      const Vec3f n = u0 < diffuse_share_ ? n_ : n_valid_;
      result.wi = Frame(n).to_world(sample_cosine_hemisphere(u1, u2));
    } else if (specular_share_ > 0) {
      if (alpha2_ <= cycles::kMirrorAlpha2V2) return sample_mirror();
      const Frame frame(n_valid_);
      const Vec3f h =
          frame.to_world(sample_ggx_visible_normal(frame.to_local(wo_), std::sqrt(alpha2_), u1, u2));
      result.wi = 2 * dot(h, wo_) * h - wo_;
    } else {
      return result;
    }
    if (!(dot(ng_, result.wi) > 0)) return result;
    // A sampled highlight counts below n and the smooth normal as well (bsdf.h).
    const BsdfValue value =
        result.is_diffuse ? eval(result.wi) : eval_lobes<float>(result.wi, dot(n_valid_, result.wi), true);
    result.value = value.value;
    result.pdf = value.pdf;
    result.is_hidden_highlight =
        !result.is_diffuse && !(dot(n_valid_, result.wi) > 0 && dot(ns_, result.wi) >= 0);
    return result;
  }

  /// sample() of up to eight numbers: those of the lobes, and of the directions.
  void sample(int count, const float* u0, const Vec2f* u, BsdfSample* samples) const {
    if (specular_share_ > 0 && alpha2_ <= cycles::kMirrorAlpha2V2) {
      for (int k = 0; k < count; ++k) samples[k] = sample(u0[k], u[k].x, u[k].y);
      return;
    }
    const Numbers8 numbers(count, u0, u);
    const Float8 zero = 0, below_share = diffuse_share_ + medium_share_, lobe = numbers.u0 - entry_share_;
    const Mask8 enters = numbers.u0 < Float8(entry_share_), has_highlight(specular_share_ > 0),
                is_diffuse = !enters && below_share > zero && (lobe < below_share || !has_highlight),
                is_specular = !enters && !is_diffuse && has_highlight;
    const Frame frame(n_valid_);
    Vec3f8 wi = to_world(frame, numbers.cosine_hemisphere());
    if (diffuse_share_ > 0)
      wi = select(lobe < Float8(diffuse_share_), to_world(Frame(n_), numbers.cosine_hemisphere()), wi);
    if (stdx::any_of(is_specular))
      wi = select(is_specular, numbers.mirrored_by_facets(frame, wo_, std::sqrt(alpha2_)), wi);
    const Float8 cos_i = dot(n_valid_, wi);
    const Mask8 is_seen = cos_i > zero && dot(ns_, wi) >= zero;
    BsdfValue8 f = eval_lobes<Float8>(wi, cos_i, is_seen || is_specular);
    f.pdf = select(dot(ng_, wi) > zero && (is_specular || is_diffuse), f.pdf, zero);
    Drawn8{wi, f, enters, is_diffuse, is_specular && !is_seen, entry_share_}.store(count, samples);
  }

  /// As in v1.
  bool is_rough() const { return !(specular_share_ > 0) || alpha2_ >= kRoughAlpha2; }

  bool is_black() const { return !(specular_share_ + diffuse_share_ + medium_share_ + entry_share_ > 0); }

  /// Factor on what enters the medium; the medium itself has the colour.
  float entry_weight() const { return entry_weight_; }

  Vec3f entry_axis() const { return n_valid_; }

  /// Half of what enters is spread about -n_valid by the cosine, half is refracted by facets of GGX alpha 1
  /// (Cycles 4.x, "random walk, skin"); (0, 0, 0) where there is none.
  Vec3f entry_direction(Vec2f u) const {
    const Frame frame(n_valid_);
    if (u.x < 0.5f) return -frame.to_world(sample_cosine_hemisphere(2 * u.x, u.y));
    if (!(cos_o_ > 0)) return {};
    const Vec3f h = frame.to_world(sample_ggx_visible_normal(frame.to_local(wo_), 1, 2 * u.x - 1, u.y));
    const float c = dot(h, wo_), inverse = 1 / cycles::kSkinEntryEta;
    const float cos_t = std::sqrt(std::max(0.0f, 1 - inverse * inverse * (1 - c * c)));
    return (inverse * c - cos_t) * h - inverse * wo_;
  }

 private:
  static Vec3f min_one(Vec3f v) { return {std::min(v.x, 1.0f), std::min(v.y, 1.0f), std::min(v.z, 1.0f)}; }

  // The layer's reflectance towards the viewer, as the tables estimate it.
  float set_up_layer(float roughness, float f0) {
    f0_ = std::min(f0, 1.0f);
    const float root = std::sqrt(std::min(f0, cycles::kMostF0V2));
    eta_ = (1 + root) / (1 - root);
    real_f0_ = root * root;
    const GgxEnergy& energy = ggx_energy();
    const float e = energy.albedo(roughness, cos_o_), e_mean = energy.mean_albedo(roughness);
    // Hemispherical mean of the Fresnel reflectance (Kulla and Conty's fit), moved between f0_ and 1.
    const float fit = (eta_ - 1) / (4.08567f + 1.00071f * eta_);
    const float f_mean = blend(std::clamp((fit - real_f0_) / (1 - real_f0_), 0.0f, 1.0f));
    const float f_many = f_mean * e_mean / (1 - f_mean * (1 - e_mean));
    const float missing = (1 - e) / e;
    scale_ = 1 + f_many * missing;
    return scale_ / (1 + missing) * blend(energy.fresnel_share(roughness, cos_o_, std::sqrt(root)));
  }

  float blend(float share) const { return f0_ + share * (1 - f0_); }

  template <class T>
  T fresnel(T c) const {
    const T zero = 0, one = 1, relative = (fresnel_dielectric(c, eta_) - real_f0_) / (1 - real_f0_);
    return f0_ + (1 - f0_) * smaller(one, larger(zero, relative));
  }

  void choose_lobes(float specular_weight, float mean_base, bool first_hit) {
    // As in v1 at the first hit: only variance depends on it.
    float weights[4] = {mean(diffuse_), mean(medium_), specular_weight,
                        cycles::kSubsurfaceLobeWeight * entry_weight_ * mean_base};
    float sum = weights[0] + weights[1] + weights[2] + weights[3];
    if (!(mean_base > cycles::kClosureWeightCutoff)) weights[0] = weights[1] = weights[3] = 0;
    if (first_hit)
      for (float& weight : weights)
        if (weight > 0) weight = std::max(weight, cycles::kDefensiveShare * sum);
    sum = weights[0] + weights[1] + weights[2] + weights[3];
    const float scale = sum > 0 ? 1 / sum : 0;
    diffuse_share_ = scale * weights[0];
    medium_share_ = scale * weights[1];
    specular_share_ = scale * weights[2];
    entry_share_ = scale * weights[3];
  }

  // What is below the layer, and the layer's highlights where they `shine`.
  template <class T>
  BsdfValueOf<T> eval_lobes(const typename Lanes<T>::Vec3& wi, T cos_i, typename Lanes<T>::Mask shine) const {
    const T zero = 0;
    BsdfValueOf<T> result;
    if (diffuse_share_ > 0) add_lambert(n_, diffuse_, diffuse_share_, wi, result);
    if (medium_share_ > 0) add_lambert(n_valid_, medium_, medium_share_, wi, result);
    if (!(specular_share_ > 0) || alpha2_ <= cycles::kMirrorAlpha2V2 || !any_of(shine)) return result;
    const Facet<T> facet(n_valid_, wo_, wi, alpha2_);
    const float lambda_o = ggx_lambda(cos_o_, alpha2_);
    const T masking = 1 + lambda_o + ggx_lambda(cos_i, alpha2_);
    const T value = select(shine, scale_ * fresnel(facet.cos_i_h) * facet.density / masking, zero);
    result.value.x += value, result.value.y += value, result.value.z += value;
    result.pdf += select(shine, specular_share_ / (1 + lambda_o) * facet.density, zero);
    return result;
  }

  template <class T>
  BsdfValueOf<T> eval_seen(const typename Lanes<T>::Vec3& wi) const {
    const T zero = 0, cos_i = dot(n_valid_, wi);
    return eval_lobes<T>(wi, cos_i, cos_i > zero && dot(ns_, wi) >= zero);
  }

  template <class T, class Vec3>
  void add_lambert(Vec3f n, Vec3f albedo, float share, const Vec3& wi, BsdfValueOf<T>& result) const {
    const T zero = 0, lambert = kInvPi * larger(dot(n, wi), zero);
    result.pdf += share * lambert;
    T value = lambert;
    if (n.x != ns_.x || n.y != ns_.y || n.z != ns_.z) value *= cycles::bump_terminator_v2<T>(ns_, n, wi);
    result.value.x += albedo.x * value, result.value.y += albedo.y * value;
    result.value.z += albedo.z * value;
  }

  BsdfSample sample_mirror() const {
    BsdfSample result;
    result.wi = 2 * cos_o_ * n_valid_ - wo_;
    if (!(dot(ng_, result.wi) > 0)) return result;
    const BsdfValue rest = eval(result.wi);
    const float value = scale_ * fresnel(cos_o_) * cycles::kMirrorDensity;
    result.value = rest.value + Vec3f{value, value, value};
    result.pdf = rest.pdf + specular_share_ * cycles::kMirrorDensity;
    return result;
  }

  Vec3f n_, n_valid_, ns_, ng_, wo_;
  Vec3f diffuse_, medium_;  // albedo of the diffuse lobe, and of the medium where nothing walks
  float cos_o_, alpha2_;
  float f0_ = 0, eta_ = 1, real_f0_ = 0, scale_ = 1;  // scale_: of single scattering, to hold all of it
  float entry_weight_, diffuse_share_, medium_share_, specular_share_, entry_share_;
};

}  // namespace ohb::renderer
