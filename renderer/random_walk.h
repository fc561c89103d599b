// A random walk under the surface, from where a path enters to where it leaves.
#pragma once

#include <cmath>

#include "renderer/intersect.h"
#include "renderer/subsurface.h"
#include "renderer/surface.h"

namespace ohb {

/// Where and how a walk left the medium.
struct WalkExit {
  Hit hit;
  Vec3f direction;  // of the last segment, outwards
  Vec3f weight;     // of the walk, by channel
};

/// Cosines about the inward or outward normal with density 1 / (nu - mu) / log((nu + 1) / (nu - 1)) in
/// [-1, 1]: the angular shape of the diffuse mode (Krivanek and d'Eon 2014, equation 5).
struct DwivediLobe {
  float nu, log_ratio;
  explicit DwivediLobe(float relaxation_mfp)
      : nu(relaxation_mfp), log_ratio(std::log((relaxation_mfp + 1) / (relaxation_mfp - 1))) {}
  float sample(float u) const { return nu - (nu + 1) * std::exp(-u * log_ratio); }
  /// In solid angle.
  float pdf(float mu) const { return 1 / (2 * kPi * log_ratio * (nu - mu)); }
};

/// What all walks from one entry share.
struct WalkMedium {
  SubsurfaceMedium medium;
  DwivediLobe lobes[3];  // of the channels
  explicit WalkMedium(const SurfaceTexel& texel)
      : medium(subsurface_medium(texel.albedo, subsurface_radius_cm(texel.sss))),
        lobes{DwivediLobe(medium.relaxation_mfp.x), DwivediLobe(medium.relaxation_mfp.y),
              DwivediLobe(medium.relaxation_mfp.z)} {}
};

/// One walk's state and choices. Each segment is drawn by one of three strategies (isotropic; towards the
/// entry; towards the far side of a sheet) with the mean free path of one of three channels; the weight is
/// the balance heuristic over all nine, in direction and distance together.
class RandomWalk {
 public:
  RandomWalk(const WalkMedium& under, Vec3f entry, Vec3f n)
      : medium_(under.medium), lobes_(under.lobes), entry_(entry), n_(n), weight_(medium_.entry_weight) {}

  const Vec3f& weight() const { return weight_; }
  bool is_over() const { return !(max_component(weight_) > kLeastWeight); }

  /// How far the first segment looks for the other side of a sheet: farther than it matters.
  float search_cm() const { return 10 / min_component(medium_.sigma_t_per_cm); }
  void set_sheet(float thickness_cm) { thickness_cm_ = thickness_cm; }

  /// Draws the first segment's length; its direction is given.
  float first_length(Random& random) {
    choose_channel(random);
    return length(random, 0);
  }
  void weigh_first(float t_cm, bool is_hit) { weigh(t_cm, is_hit, 0, false); }

  /// Draws direction and length of a later segment that starts at `position`.
  float next(Vec3f position, Random& random, Vec3f& direction) {
    choose_channel(random);
    backward_ = 0;
    if (thickness_cm_ < std::numeric_limits<float>::infinity()) {
      // The diffuse modes of both faces, at this depth of the sheet.
      const float depth_cm = std::clamp(dot(entry_ - position, n_), 0.0f, thickness_cm_);
      const float decay_cm = lobes_[channel_].nu / medium_.sigma_t_per_cm[channel_];
      backward_ = 1 / (1 + std::exp(std::min(80.0f, (thickness_cm_ - 2 * depth_cm) / decay_cm)));
    }
    const float u_strategy = random.next(), u = random.next(), u_phi = random.next();
    float side = 0;
    if (u_strategy < kGuidedShare) side = u_strategy < kGuidedShare * backward_ ? -1.0f : 1.0f;
    const float mu = side == 0 ? 1 - 2 * u : side * std::clamp(lobes_[channel_].sample(u), -1.0f, 1.0f);
    const float sine = std::sqrt(std::max(0.0f, 1 - mu * mu));
    const SineCosine phi = sine_cosine_of_turns(u_phi);
    direction = Frame(n_).to_world({sine * phi.cosine, sine * phi.sine, mu});
    mu_ = mu;
    return length(random, side * mu);
  }
  void weigh_next(float t_cm, bool is_hit) { weigh(t_cm, is_hit, mu_, true); }

 private:
  static constexpr float kGuidedShare = 0.75f;
  static constexpr float kLeastWeight = 1e-6f;

  void choose_channel(Random& random) {
    const Vec3f p = weight_ * medium_.albedo;
    const float sum = p.x + p.y + p.z;
    share_ = p / sum;
    const float u = random.next();
    channel_ = u < share_.x ? 0 : u < share_.x + share_.y ? 1 : 2;
  }

  /// `mu_towards`: cosine with the side that is guided to; 0 leaves the extinction as it is.
  float length(Random& random, float mu_towards) const {
    const float sigma = medium_.sigma_t_per_cm[channel_] * (1 - mu_towards / lobes_[channel_].nu);
    return -std::log(1 - random.next()) / sigma;
  }

  // pdf of (direction, t) or, on a hit, of (direction, longer than t), over what the medium does.
  void weigh(float t_cm, bool is_hit, float mu, bool has_direction) {
    float pdf = 0;
    Vec3f transmitted;
    for (int c = 0; c < 3; ++c) {
      const float sigma = medium_.sigma_t_per_cm[c];
      transmitted[c] = std::exp(-sigma * t_cm);
      const float plain = (is_hit ? 1 : sigma) * transmitted[c];
      float strategies = plain;
      if (has_direction) {
        const float stretch = mu / lobes_[c].nu;
        strategies = (1 - kGuidedShare) * plain / (4 * kPi);
        strategies += kGuidedShare * (1 - backward_) * lobes_[c].pdf(mu) *
                      (is_hit ? 1 : sigma * (1 - stretch)) * std::exp(-sigma * (1 - stretch) * t_cm);
        if (backward_ > 0)
          strategies += kGuidedShare * backward_ * lobes_[c].pdf(-mu) * (is_hit ? 1 : sigma * (1 + stretch)) *
                        std::exp(-sigma * (1 + stretch) * t_cm);
      }
      pdf += share_[c] * strategies;
    }
    const float phase = has_direction ? 1 / (4 * kPi) : 1.0f;
    Vec3f factor = phase / pdf * transmitted;
    if (!is_hit) factor = factor * medium_.albedo * medium_.sigma_t_per_cm;
    weight_ = weight_ * factor;
  }

  const SubsurfaceMedium& medium_;
  const DwivediLobe* lobes_;
  Vec3f entry_, n_;
  Vec3f weight_, share_{};
  float thickness_cm_ = std::numeric_limits<float>::infinity();
  float backward_ = 0, mu_ = 0;
  int channel_ = 0;
};

/// The closest surface within t_far, cut-outs counted as solid (Cycles' walks do not ask for their alpha).
/// `skip` is a triangle that is not seen: the one that a walk enters by.
template <bool kCutouts>
bool intersect_solid(const Scene& scene, const Ray& ray, float t_far, uint32_t skip, RayCounts& counts,
                     Hit& hit) {
  const auto closest = [&](RTCScene bvh, uint32_t first, float far, bool is_cutout) {
    float t_near = 0;
    Hit found;
    while (true) {
      ++counts.walk_segments;
      record_ray(counts, ray, t_near, far, false, is_cutout);
      if (!intersect_bvh(bvh, first, ray, t_near, far, found)) return false;
      if (found.triangle != skip) break;
      t_near = beyond(found.t, t_near);
    }
    hit = found;
    return true;
  };
  bool found = scene.opaque && closest(scene.opaque, 0, t_far, false);
  if constexpr (kCutouts) found |= closest(scene.cutout, scene.opaque_count, found ? hit.t : t_far, true);
  return found;
}

/// Walks from `entry` (seen from outside) until the surface is met again. False if it never is: killed at the
/// entry, absorbed, or not out after cycles::kMaxWalkSegments, which loses energy that Cycles loses too.
/// n: the axis that walks are guided along.
template <bool kCutouts>
bool walk_under_surface(const Scene& scene, const SurfacePoint& entry, uint32_t triangle,
                        const WalkMedium& medium, Vec3f n, Vec3f entry_direction, Random& random,
                        RayCounts& counts, WalkExit& exit) {
  ++counts.walks;
  Ray ray{entry.position, entry_direction};
  if (!(dot(entry.ng, ray.direction) < 0)) return false;
  RandomWalk walk(medium, entry.position, n);
  if (walk.is_over()) return false;
  for (int segment = 0; segment < cycles::kMaxWalkSegments; ++segment) {
    const bool is_first = segment == 0;
    float t = is_first ? walk.first_length(random) : walk.next(ray.origin, random, ray.direction);
    const float t_far = is_first ? std::max(t, walk.search_cm()) : t;
    bool is_hit =
        intersect_solid<kCutouts>(scene, ray, t_far, is_first ? triangle : kNoTriangle, counts, exit.hit);
    if (is_first && is_hit && dot(geometric_normal(scene, exit.hit.triangle), entry.ng) < 0)
      walk.set_sheet(exit.hit.t * -dot(ray.direction, n));
    is_hit = is_hit && exit.hit.t < t;
    if (is_hit) t = exit.hit.t;
    if (is_first)
      walk.weigh_first(t, is_hit);
    else
      walk.weigh_next(t, is_hit);
    if (is_hit) {
      exit.direction = ray.direction;
      exit.weight = walk.weight();
      return is_finite(exit.weight);
    }
    ray.origin += t * ray.direction;
    if (walk.is_over()) break;
  }
  counts.walk_leaks += !is_within(scene.bounds, ray.origin);
  return false;
}

}  // namespace ohb
