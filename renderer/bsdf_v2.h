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
inline float ggx_lambda(float c, float alpha2) {
  return 0.5f * (std::sqrt(1 + alpha2 * std::max(0.0f, 1 / (c * c) - 1)) - 1);
}

class PrincipledV2 {
 public:
  /// How much of the light below the layer goes into the medium, and whether it walks there or (after a
  /// diffuse bounce) leaves at once, as from a diffuse surface about n_valid.
  struct Subsurface {
    float weight = 0;
    bool walks = false;
  };

  PrincipledV2(Vec3f base, float roughness, float f0, Subsurface subsurface, Vec3f n, Vec3f n_valid, Vec3f ns,
               Vec3f ng, Vec3f wo, bool first_hit)
      : n_(n), n_valid_(n_valid), ns_(ns), ng_(ng), wo_(wo), cos_o_(dot(n_valid, wo)) {
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

  /// f cos and the mixture's pdf for a given direction; a mirror lobe counts as 0.
  BsdfValue eval(Vec3f wi) const {
    BsdfValue result;
    add_below(wi, result);
    const float cos_i = dot(n_valid_, wi);
    if (specular_share_ > 0 && alpha2_ > cycles::kMirrorAlpha2V2 && cos_i > 0 && dot(ns_, wi) >= 0)
      add_specular(wi, cos_i, result);
    return result;
  }

  /// eval() of eight directions.
  BsdfValue8 eval(const Vec3f8& wi) const {
    const Float8 zero = 0, cos_i = dot(n_valid_, wi);
    return eval_lobes(wi, cos_i, cos_i > zero && dot(ns_, wi) >= zero);
  }

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
    // A sampled highlight counts below n and the smooth normal as well (bsdf.h, eval_sampled_specular).
    BsdfValue value;
    if (result.is_diffuse) {
      value = eval(result.wi);
    } else {
      add_below(result.wi, value);
      add_specular(result.wi, dot(n_valid_, result.wi), value);
    }
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
    const BsdfValue8 f = eval_lobes(wi, cos_i, is_seen || is_specular);
    const Mask8 is_left = dot(ng_, wi) > zero && (is_specular || is_diffuse);
    store(count, wi, {f.value, select(is_left, f.pdf, zero)}, enters, entry_share_, is_diffuse,
          is_specular && !is_seen, samples);
  }

  /// As in v1.
  bool is_rough() const { return !(specular_share_ > 0) || alpha2_ >= kRoughAlpha2; }

  bool is_black() const { return !(specular_share_ + diffuse_share_ + medium_share_ + entry_share_ > 0); }

  /// As in v1.
  PrincipledV2 highlight() const {
    PrincipledV2 part = *this;
    part.diffuse_share_ = part.medium_share_ = part.entry_share_ = 0;
    part.specular_share_ = specular_share_ > 0 ? 1.0f : 0.0f;
    return part;
  }
  PrincipledV2 without_highlight() const {
    PrincipledV2 part = *this;
    part.specular_share_ = 0;
    const float rest = diffuse_share_ + medium_share_ + entry_share_;
    for (float* share : {&part.diffuse_share_, &part.medium_share_, &part.entry_share_})
      if (rest > 0) *share /= rest;
    return part;
  }

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

  float fresnel(float c) const {
    return blend(std::clamp((fresnel_dielectric(c, eta_) - real_f0_) / (1 - real_f0_), 0.0f, 1.0f));
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

  void add_below(Vec3f wi, BsdfValue& result) const {
    if (diffuse_share_ > 0) add_lambert(n_, diffuse_, diffuse_share_, wi, result);
    if (medium_share_ > 0) add_lambert(n_valid_, medium_, medium_share_, wi, result);
  }

  void add_lambert(Vec3f n, Vec3f albedo, float share, Vec3f wi, BsdfValue& result) const {
    const float value = dot(n, wi) * kInvPi;
    if (!(value > 0)) return;
    result.pdf += share * value;
    const bool bumped = n.x != ns_.x || n.y != ns_.y || n.z != ns_.z;
    result.value += (bumped ? value * cycles::bump_terminator_v2(ns_, n, wi) : value) * albedo;
  }

  void add_specular(Vec3f wi, float cos_i, BsdfValue& result) const {
    const Vec3f h = normalised(wi + wo_);
    const float cos_h = dot(n_valid_, h);
    if (!(cos_h > 0)) return;
    const Vec3f sine = cross(n_valid_, h);
    const float t = alpha2_ * cos_h * cos_h + dot(sine, sine);
    const float common = alpha2_ * kInvPi / (t * t) / (4 * cos_o_);
    const float lambda_o = ggx_lambda(cos_o_, alpha2_), lambda_i = ggx_lambda(cos_i, alpha2_);
    const float value = scale_ * fresnel(dot(wi, h)) * common / (1 + lambda_o + lambda_i);
    result.value += Vec3f{value, value, value};
    result.pdf += specular_share_ * common / (1 + lambda_o);
  }

  // What is below the layer, and the layer's highlights where they `shine`.
  BsdfValue8 eval_lobes(const Vec3f8& wi, Float8 cos_i, Mask8 shine) const {
    const Float8 zero = 0, one = 1;
    BsdfValue8 result{{0, 0, 0}, 0};
    if (diffuse_share_ > 0) add_lambert(n_, diffuse_, diffuse_share_, wi, result);
    if (medium_share_ > 0) add_lambert(n_valid_, medium_, medium_share_, wi, result);
    if (!(specular_share_ > 0) || alpha2_ <= cycles::kMirrorAlpha2V2) return result;
    const Vec3f8 h = halfway(wo_, wi);
    const Float8 cos_h = dot(n_valid_, h);
    const Vec3f8 sine = cross(n_valid_, h);
    const Float8 t = alpha2_ * cos_h * cos_h + dot(sine, sine);
    const Float8 common = alpha2_ * kInvPi / (4 * cos_o_) / (t * t);
    const float lambda_o = ggx_lambda(cos_o_, alpha2_);
    const Float8 lambda_i = 0.5f * (sqrt(1 + alpha2_ * stdx::max(zero, 1 / (cos_i * cos_i) - 1)) - 1);
    const Float8 relative = (fresnel_dielectric(dot(wi, h), eta_) - real_f0_) / (1 - real_f0_);
    const Float8 fresnel = f0_ + (1 - f0_) * stdx::min(one, stdx::max(zero, relative));
    const Mask8 counts = shine && cos_h > zero;
    const Float8 value = select(counts, scale_ * fresnel * common / (1 + lambda_o + lambda_i), zero);
    result.value.x += value, result.value.y += value, result.value.z += value;
    result.pdf += select(counts, specular_share_ / (1 + lambda_o) * common, zero);
    return result;
  }

  void add_lambert(Vec3f n, Vec3f albedo, float share, const Vec3f8& wi, BsdfValue8& result) const {
    const Float8 zero = 0, one = 1, cos_i = dot(n, wi);
    const Float8 lambert = kInvPi * stdx::max(cos_i, zero);
    result.pdf += share * lambert;
    Float8 value = lambert;
    if (n.x != ns_.x || n.y != ns_.y || n.z != ns_.z) {
      // cycles::bump_terminator_v2
      const float cos_tilt = dot(ns_, n);
      const Float8 c = dot(ns_, wi), size = abs(c);
      const float alpha2 = std::clamp(0.125f * (1 / (cos_tilt * cos_tilt) - 1), 0.0f, 1.0f);
      Float8 factor = 2 / (1 + sqrt(1 + alpha2 * (1 / (c * c) - 1)));
      factor = select(size < Float8(1e-6f), zero, factor);
      factor = select(Mask8(std::fabs(cos_tilt) >= 1) || size >= one, one, factor);
      value *= select(c * cos_tilt * cos_i < zero, zero, factor);
    }
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
