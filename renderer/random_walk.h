// A random walk under the surface, from where a path enters to where it leaves.
#pragma once

#include <cmath>

#include "renderer/eight.h"
#include "renderer/intersect.h"
#include "renderer/subsurface.h"
#include "renderer/surface.h"

namespace ohb::renderer {

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

/// A ray that asks for the closest surface within t_far, and what it found. Cut-outs count as solid (Cycles'
/// walks do not ask for their alpha). `skip` is a triangle that is not seen: the one that a walk enters by.
struct SolidRay {
  Ray ray;
  float t_far;
  uint32_t skip;
  bool is_hit;
  Hit hit;
};

/// Those of eight whose `lanes` are -1, not 0, in one bounding volume hierarchy, each as far as what it has
/// found before.
inline void intersect_solids_of(RTCScene bvh, uint32_t first_triangle, bool is_cutout, const int* lanes,
                                SolidRay* rays, RayCounts& counts) {
  alignas(32) int valid[8];
  std::copy(lanes, lanes + 8, valid);
  float t_near[8] = {};
  for (bool any = true; any;) {
    RTCRayHit8 r;
    for (int i = 0; i < 8; ++i) {
      if (!valid[i]) continue;
      const SolidRay& asked = rays[i];
      const float t_far = asked.is_hit ? asked.hit.t : asked.t_far;
      set_lane(r.ray, i, asked.ray, t_far);
      r.ray.tnear[i] = t_near[i];
      r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      ++counts.walk_segments;
      record_ray(counts, asked.ray, t_near[i], t_far, false, is_cutout);
    }
    surface::intersect_eight(bvh, valid, r, false);
    any = false;
    for (int i = 0; i < 8; ++i) {
      if (!valid[i]) continue;
      valid[i] = 0;
      if (r.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const Hit found{first_triangle + r.hit.primID[i], r.hit.u[i], r.hit.v[i], r.ray.tfar[i]};
      if (found.triangle == rays[i].skip) {
        t_near[i] = surface::beyond(found.t, t_near[i]);
        valid[i] = -1, any = true;
      } else {
        rays[i].is_hit = true;
        rays[i].hit = found;
      }
    }
  }
}

template <bool kCutouts>
void intersect_solids(const Scene& scene, const int* lanes, SolidRay* rays, RayCounts& counts) {
  if (scene.opaque) intersect_solids_of(scene.opaque, 0, false, lanes, rays, counts);
  if constexpr (kCutouts) intersect_solids_of(scene.cutout, scene.opaque_count, true, lanes, rays, counts);
}

/// A walk from where a path enters, seen from outside, until it meets the surface again.
struct Walk {
  Vec3f position, ng;  // of the entry
  Vec3f n;             // the axis that the walk is guided along
  Vec3f direction;     // of the first segment
  uint32_t triangle;   // of the entry
  const WalkMedium* medium;
  Random random;  // its own: what one walk draws does not change the next
  /// False if it never comes out: killed at the entry, absorbed, or not out after cycles::kMaxWalkSegments,
  /// which loses energy that Cycles loses too.
  bool is_out = false;
  WalkExit exit{};
};

/// Eight walks side by side, their states and choices. Each segment is drawn by one of three strategies
/// (isotropic; towards the entry; towards the far side of a sheet) with the mean free path of one of three
/// channels; the weight is the balance heuristic over all nine, in direction and distance together.
class WalkLanes {
 public:
  WalkLanes() {
    // Lanes that never hold a walk need anything finite.
    for (Value* value : {&t_, &mu_, &depth_}) value->set(Float8(0));
    for (int c = 0; c < 3; ++c) {
      for (Value* value : {&position_[c], &direction_[c], &s_[c], &b_[c], &n_[c], &backward_[c]})
        value->set(Float8(0));
      for (Value* value : {&weight_[c], &sigma_[c], &albedo_[c], &log_ratio_[c]}) value->set(Float8(1));
      nu_[c].set(Float8(2));
    }
    thickness_.set(Float8(std::numeric_limits<float>::infinity()));
  }

  bool is_free(int lane) const { return !walk_[lane]; }
  const Walk& walk(int lane) const { return *walk_[lane]; }

  /// False if it ends where it enters.
  bool start(int lane, Walk& walk) {
    const SubsurfaceMedium& medium = walk.medium->medium;
    if (!(dot(walk.ng, walk.direction) < 0) || !(max_component(medium.entry_weight) > kLeastWeight))
      return false;
    walk_[lane] = &walk;
    segment_[lane] = 0;
    const Frame frame(walk.n);
    for (int c = 0; c < 3; ++c) {
      position_[c].lane[lane] = walk.position[c];
      direction_[c].lane[lane] = walk.direction[c];
      s_[c].lane[lane] = frame.s[c], b_[c].lane[lane] = frame.t[c], n_[c].lane[lane] = walk.n[c];
      weight_[c].lane[lane] = medium.entry_weight[c];
      sigma_[c].lane[lane] = medium.sigma_t_per_cm[c];
      albedo_[c].lane[lane] = medium.albedo[c];
      nu_[c].lane[lane] = walk.medium->lobes[c].nu;
      log_ratio_[c].lane[lane] = walk.medium->lobes[c].log_ratio;
    }
    depth_.lane[lane] = dot(walk.position, walk.n);
    thickness_.lane[lane] = std::numeric_limits<float>::infinity();
    return true;
  }

  /// Draws every walk's next segment.
  void draw() {
    alignas(32) float u[5][8] = {};
    alignas(32) float first[8];
    for (int k = 0; k < 8; ++k) {
      first[k] = segment_[k] == 0 ? 1.0f : 0.0f;
      if (!walk_[k]) continue;
      u[0][k] = walk_[k]->random.next();
      for (int i = 1; i < 4 && segment_[k] > 0; ++i) u[i][k] = walk_[k]->random.next();
      u[4][k] = walk_[k]->random.next();
    }
    const auto number = [&](int i) { return Float8(u[i], stdx::vector_aligned); };
    const Mask8 is_first = Float8(first, stdx::vector_aligned) > Float8(0);
    Float8 share[3], sum = 0;
    for (int c = 0; c < 3; ++c) sum += share[c] = weight_[c].get() * albedo_[c].get();
    for (int c = 0; c < 3; ++c) share_[c].set(share[c] /= sum);
    const Mask8 is_red = number(0) < share[0], is_green = number(0) < share[0] + share[1];
    const auto of_channel = [&](const Value* values) {
      return select(is_red, values[0].get(), select(is_green, values[1].get(), values[2].get()));
    };
    const Float8 sigma = of_channel(sigma_), nu = of_channel(nu_), log_ratio = of_channel(log_ratio_);
    // The diffuse modes of both faces of a sheet, at this depth. Each channel has its own: the weight asks
    // what every one of them would have drawn.
    const Float8 thickness = thickness_.get();
    const Vec3f8 n = vector(n_);
    const Float8 depth = stdx::min(stdx::max(depth_.get() - dot(vector(position_), n), Float8(0)), thickness);
    const Mask8 has_sheet = thickness < Float8(std::numeric_limits<float>::infinity()) && !is_first;
    has_sheets_ = stdx::any_of(has_sheet);
    for (int c = 0; c < 3 && has_sheets_; ++c) {
      const Float8 decays = stdx::min(Float8(80), (thickness - 2 * depth) * sigma_[c].get() / nu_[c].get());
      backward_[c].set(select(has_sheet, 1 / (1 + exp_of(select(has_sheet, decays, Float8(0)))), Float8(0)));
    }
    const Float8 backward = has_sheets_ ? of_channel(backward_) : Float8(0);
    Float8 side = select(number(1) < kGuidedShare * backward, Float8(-1), Float8(1));
    side = select(number(1) < Float8(kGuidedShare) && !is_first, side, Float8(0));
    const Float8 guided = nu - (nu + 1) * exp_of(-number(2) * log_ratio);
    const Float8 mu = select(side == Float8(0), 1 - 2 * number(2),
                             side * stdx::min(stdx::max(guided, Float8(-1)), Float8(1)));
    const Float8 sine = stdx::sqrt(stdx::max(Float8(0), 1 - mu * mu));
    Float8 sine_phi, cosine_phi;
    sine_cosine_of_turns(number(3), sine_phi, cosine_phi);
    for (int c = 0; c < 3; ++c)
      direction_[c].set(
          select(is_first, direction_[c].get(),
                 sine * cosine_phi * s_[c].get() + sine * sine_phi * b_[c].get() + mu * n_[c].get()));
    const Float8 t = -log_of(1 - number(4)) / (sigma * (1 - side * mu / nu));
    t_.set(t), mu_.set(mu);
  }

  /// What draw() drew, as rays. A first one looks farther than it goes, for the other side of a sheet:
  /// farther than that matters.
  void set_rays(SolidRay* rays) const {
    for (int k = 0; k < 8; ++k) {
      if (!walk_[k]) continue;
      float t_far = t_.lane[k];
      if (segment_[k] == 0)
        t_far = std::max(t_far, 10 / min_component(walk_[k]->medium->medium.sigma_t_per_cm));
      rays[k] = {{at(position_, k), at(direction_, k)},
                 t_far,
                 segment_[k] == 0 ? walk_[k]->triangle : surface::kNoTriangle,
                 false,
                 {}};
    }
  }

  /// Goes to what the rays found; walks that are over leave their lanes. Returns how many.
  int go(const Scene& scene, const SolidRay* rays, RayCounts& counts) {
    alignas(32) float first[8], hit[8];
    for (int k = 0; k < 8; ++k) {
      first[k] = segment_[k] == 0 ? 1.0f : 0.0f;
      hit[k] = 0;
      if (!walk_[k] || !rays[k].is_hit) continue;
      const Hit& found = rays[k].hit;
      if (segment_[k] == 0 && dot(geometric_normal(scene, found.triangle), walk_[k]->ng) < 0)
        thickness_.lane[k] = found.t * -dot(walk_[k]->direction, walk_[k]->n);
      if (found.t < t_.lane[k]) hit[k] = 1, t_.lane[k] = found.t;
    }
    weigh(Float8(hit, stdx::vector_aligned) > Float8(0), Float8(first, stdx::vector_aligned) > Float8(0));
    int over = 0;
    for (int k = 0; k < 8; ++k) {
      if (!walk_[k]) continue;
      ++segment_[k];
      const Vec3f weight = at(weight_, k);
      const bool is_hit = hit[k] > 0;
      if (is_hit) {
        walk_[k]->exit = {rays[k].hit, at(direction_, k), weight};
        walk_[k]->is_out = is_finite(weight);
      }
      if (!is_hit && max_component(weight) > kLeastWeight && segment_[k] < cycles::kMaxWalkSegments) continue;
      if (!is_hit) counts.walk_leaks += !is_within(scene.bounds, at(position_, k));
      walk_[k] = nullptr;
      ++over;
    }
    return over;
  }

 private:
  static constexpr float kGuidedShare = 0.75f;
  static constexpr float kLeastWeight = 1e-6f;

  struct alignas(32) Value {
    float lane[8];
    Float8 get() const { return Float8(lane, stdx::vector_aligned); }
    void set(Float8 value) { value.copy_to(lane, stdx::vector_aligned); }
  };
  static Vec3f8 vector(const Value* values) { return {values[0].get(), values[1].get(), values[2].get()}; }
  static Vec3f at(const Value* values, int k) {
    return {values[0].lane[k], values[1].lane[k], values[2].lane[k]};
  }

  // pdf of (direction, t) or, on a hit, of (direction, longer than t), over what the medium does.
  void weigh(Mask8 is_hit, Mask8 is_first) {
    const Float8 t = t_.get(), mu = mu_.get(), one = 1;
    Float8 pdf = 0, transmitted[3];
    for (int c = 0; c < 3; ++c) {
      const Float8 sigma = sigma_[c].get(), nu = nu_[c].get(), stretch = mu / nu;
      transmitted[c] = exp_of(-sigma * t);
      const Float8 plain = select(is_hit, one, sigma) * transmitted[c];
      // A Dwivedi lobe's density in solid angle, times that of the distance.
      const Float8 backward = has_sheets_ ? backward_[c].get() : Float8(0);
      const Float8 guided = kGuidedShare / (2 * kPi * log_ratio_[c].get());
      Float8 strategies = (1 - kGuidedShare) / (4 * kPi) * plain;
      strategies += (1 - backward) * guided / (nu - mu) * select(is_hit, one, sigma * (1 - stretch)) *
                    exp_of(-sigma * (1 - stretch) * t);
      if (has_sheets_)
        strategies += backward * guided / (nu + mu) * select(is_hit, one, sigma * (1 + stretch)) *
                      exp_of(-sigma * (1 + stretch) * t);
      pdf += share_[c].get() * select(is_first, plain, strategies);
    }
    const Float8 scale = select(is_first, one, Float8(1 / (4 * kPi))) / pdf;
    for (int c = 0; c < 3; ++c) {
      const Float8 scattered = select(is_hit, one, albedo_[c].get() * sigma_[c].get());
      weight_[c].set(weight_[c].get() * scale * transmitted[c] * scattered);
      position_[c].set(position_[c].get() + t * direction_[c].get());
    }
  }

  Walk* walk_[8] = {};
  int segment_[8] = {};
  Value position_[3], direction_[3], s_[3], b_[3], n_[3];  // the axis and a frame about it
  Value weight_[3], share_[3], sigma_[3], albedo_[3], nu_[3], log_ratio_[3];
  Value backward_[3];                 // of what is guided, by channel
  Value depth_, thickness_, mu_, t_;  // depth_: of the entry along the axis
  bool has_sheets_ = false;           // any lane's segment
};

/// All walks to their ends, eight at once; a lane whose walk is over takes the next one.
template <bool kCutouts>
void walk_under_surface(const Scene& scene, std::vector<Walk>& walks, RayCounts& counts) {
  WalkLanes lanes;
  counts.walks += walks.size();
  size_t next = 0;
  int free = 8;
  while (true) {
    for (int k = 0; k < 8 && free > 0 && next < walks.size(); ++k)
      while (lanes.is_free(k) && next < walks.size()) free -= lanes.start(k, walks[next++]);
    if (free == 8) return;
    SolidRay rays[8];
    lanes.draw();
    lanes.set_rays(rays);
    alignas(32) int valid[8];
    for (int k = 0; k < 8; ++k) valid[k] = lanes.is_free(k) ? 0 : -1;
    intersect_solids<kCutouts>(scene, valid, rays, counts);
    free += lanes.go(scene, rays, counts);
  }
}

}  // namespace ohb::renderer
