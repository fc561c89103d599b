// One path serves all lights: the way through the scene does not depend on them, so each vertex asks every
// light for its share (next-event estimation), and a ray that leaves the scene asks every environment.
// The estimate of light l is a sum over path vertices of
//   throughput x [ f cos L_l(wi) V / pdf_l  w(pdf_l, pdf_bsdf)            (light sampling)
//               or f cos L_l(wi) / pdf_bsdf w(pdf_bsdf, pdf_l) ]           (BSDF sampling)
// with w the power heuristic between that light's own density and the BSDF's: unbiased for each light alone.
#pragma once

#include "renderer/lights.h"
#include "renderer/random_walk.h"
#include "renderer/surface.h"

namespace ohb {

constexpr int kCandidates = 8;         // directions of an environment that compete for a shadow ray
constexpr float kCandidatesWorth = 3;  // in directions of the BSDF's own, measured; any value is unbiased
// The first surface that the camera sees sends several rays on: they share the way to it.
constexpr int kWalks = 4;                    // under it
constexpr int kShadowRays = 4;               // to a single environment, where no walks are made
constexpr int kReflections = 2;              // from rough surfaces without walks
constexpr int kNarrowReflections = 4;        // from others, which find their highlights by reflections
constexpr float kLatticeStep = 0.61803399f;  // golden section: a lattice of any size is even
constexpr int kRouletteFromBounce = 2;       // Cycles: the continuation test starts at the third surface

/// What the paths of one tile share, and what they did.
struct Tile {
  std::vector<LightPool> pools;  // one an environment
  RayCounts rays;
  uint64_t paths = 0;
  uint64_t nonfinite = 0;
};

// Everything that one pixel's paths share.
struct PathContext {
  const Scene& scene;
  const LightSet& lights;
  double turn_rad;
  Vec3f turn_x, turn_z;  // the world's X and Z axes in the subject's frame
  int max_bounces;
  bool ends_at_rough_surfaces;
  bool subsurface;

  Vec3f to_world(Vec3f v) const { return {dot(v, turn_x), v.y, dot(v, turn_z)}; }
};

inline float fraction_of(float x) {
  return x - std::floor(x);
}

inline void add(Vec3f contribution, Vec3f& sum, Tile& tile) {
  if (is_finite(contribution))
    sum += contribution;
  else
    ++tile.nonfinite;
}

/// Point k of a lattice of n that is shifted by u.
inline Vec2f lattice_point(Vec2f u, int k, int n) {
  const float kf = static_cast<float>(k);
  return {fraction_of(u.x + kf / static_cast<float>(n)), fraction_of(u.y + kf * kLatticeStep)};
}

/// Numbers for one question to the lights. The candidates lie in order along the first coordinate of the
/// lights' own numbers: choosing one and shifting them all in that coordinate place the shadow ray together,
/// so these two are stratified as a pair.
struct LightNumbers {
  Vec2f along;   // choice, shift
  float across;  // shift in the other coordinate

  /// Number k of n that spread.
  LightNumbers of(int k, int n) const {
    constexpr float kThirdStep = 0.7548777f;  // of the plastic number: unlike kLatticeStep
    return {lattice_point(along, k, n), fraction_of(across + static_cast<float>(k) * kThirdStep)};
  }
};

/// One shadow ray to one of several directions that the environment suggests, chosen by what each would
/// bring if it is not shadowed (resampled importance sampling, Talbot et al. 2005, equation 6). The
/// candidates are a lattice, so that they spread over the light.
template <bool kCutouts, class Bsdf>
void sample_environment(const PathContext& c, const LightPool& pool, const SurfacePoint& point,
                        const Bsdf& bsdf, Vec3f throughput, const LightNumbers& u, float worth, Tile& tile,
                        Vec3f& radiance) {
  static_assert(kCandidates == 8);
  const Vec2f shift{u.along.y / kCandidates, u.across};
  const LightCandidate* candidates[kCandidates];
  for (int k = 0; k < kCandidates; ++k) candidates[k] = &pool.at(lattice_point(shift, k, kCandidates));
  const auto gather = [&](auto member) { return Float8([&](auto k) { return member(*candidates[k]); }); };
  const Vec3f8 wi{gather([](const LightCandidate& l) { return l.wi.x; }),
                  gather([](const LightCandidate& l) { return l.wi.y; }),
                  gather([](const LightCandidate& l) { return l.wi.z; })};
  const Vec3f8 light{gather([](const LightCandidate& l) { return l.radiance.x; }),
                     gather([](const LightCandidate& l) { return l.radiance.y; }),
                     gather([](const LightCandidate& l) { return l.radiance.z; })};
  const Float8 pdf = gather([](const LightCandidate& l) { return l.pdf; });
  const BsdfValue8 f = bsdf.eval(wi);
  // The power heuristic over the pdf.
  const Float8 ratio = f.pdf / (worth * pdf), scale = 1 / (pdf * (1 + ratio * ratio));
  const Vec3f8 value{throughput.x * f.value.x * light.x * scale, throughput.y * f.value.y * light.y * scale,
                     throughput.z * f.value.z * light.z * scale};
  const Float8 zero = 0;
  const Float8 weight = select(pdf > zero, (value.x + value.y + value.z) * (1.0f / 3), zero);
  float sums[kCandidates], sum = 0;
  for (int k = 0; k < kCandidates; ++k) sums[k] = sum += weight[k];
  if (!std::isfinite(sum)) ++tile.nonfinite;
  if (!(sum > 0) || !std::isfinite(sum)) return;
  int chosen = 0;
  while (chosen + 1 < kCandidates && !(u.along.x * sum < sums[chosen])) ++chosen;
  const float chosen_weight = weight[chosen];
  if (!(chosen_weight > 0)) return;
  const Vec3f chosen_wi = candidates[chosen]->wi;
  const Vec3f chosen_value{value.x[chosen], value.y[chosen], value.z[chosen]};
  const Ray ray{ray_origin(c.scene, point.position, point.ng, chosen_wi), chosen_wi};
  const float visible =
      transmittance<kCutouts>(c.scene, ray, std::numeric_limits<float>::infinity(), tile.rays);
  if (visible > 0)
    add(chosen_value * (visible * sum / (chosen_weight * static_cast<float>(kCandidates))), radiance, tile);
}

/// How many rays leave a surface, and how they count.
struct Split {
  int shadow_rays = 1;  // to each environment
  int reflections = 1;
  /// Of all directions that an environment suggests against one that the BSDF draws, in the heuristic;
  /// infinite: it draws none.
  float worth = kCandidatesWorth;

  static Split none() { return {1, 0, std::numeric_limits<float>::infinity()}; }
  /// At the first surface. Each further light makes shadow rays dearer against what they share.
  static Split of_first(size_t environments, bool is_rough) {
    const int shared = environments <= 1 ? 1 : environments <= 3 ? 2 : 4;
    const int shadow_rays = std::max(1, kShadowRays / (is_rough ? shared : 2 * shared));
    const int reflections = is_rough ? kReflections : kNarrowReflections;
    return {shadow_rays, reflections,
            kCandidatesWorth * static_cast<float>(shadow_rays) / static_cast<float>(reflections)};
  }
};

template <bool kCutouts, class Bsdf>
void sample_lights(const PathContext& c, const SurfacePoint& point, const Bsdf& bsdf, Vec3f throughput,
                   const LightNumbers& u, const Split& split, Tile& tile, std::vector<Vec3f>& radiance) {
  // One set of numbers for all lights: each light's image is unbiased by itself.
  const Vec3f share = throughput / static_cast<float>(split.shadow_rays);
  for (size_t l = 0; l < c.lights.environments.size(); ++l)
    for (int k = 0; k < split.shadow_rays; ++k)
      sample_environment<kCutouts>(c, tile.pools[l], point, bsdf, share, u.of(k, split.shadow_rays),
                                   split.worth, tile, radiance[l]);
  for (size_t i = 0; i < c.lights.points.size(); ++i) {
    const PointLight& light = c.lights.points[i];
    const Vec3f to_light = turn_about_y(light.position_cm, -c.turn_rad) - point.position;
    const float distance_cm = length(to_light);
    if (!(distance_cm > 0)) continue;
    const Vec3f wi = to_light / distance_cm;
    const BsdfValue f = bsdf.eval(wi);
    if (!(max_component(f.value) > 0)) continue;
    const Ray ray{ray_origin(c.scene, point.position, point.ng, wi), wi};
    const float visible = transmittance<kCutouts>(c.scene, ray, distance_cm, tile.rays);
    const float distance_m = distance_cm * 0.01f;
    add(throughput * f.value * (visible * light.intensity / (distance_m * distance_m)),
        radiance[c.lights.environments.size() + i], tile);
  }
}

inline void add_environments(const PathContext& c, Vec3f direction, float bsdf_pdf, float worth,
                             Vec3f throughput, Tile& tile, std::vector<Vec3f>& radiance) {
  const MapPlace place = map_place(c.to_world(direction));
  for (size_t l = 0; l < c.lights.environments.size(); ++l) {
    const EnvironmentLight& light = c.lights.environments[l];
    const EnvironmentValue value = light.at(place);
    add(throughput * value.radiance * power_heuristic(bsdf_pdf, worth * value.pdf), radiance[l], tile);
  }
}

/// What a path carries from one surface to the next.
struct PathState {
  Ray ray;
  Vec3f throughput{1, 1, 1};
  float bsdf_pdf = 0;
  float lights_worth = 0;  // of the environments' directions against this one
  int bounce = 0;
  bool diffuse_ancestor = false;  // walks are made before the first diffuse bounce only
};

/// The next segment of a path that reflects at `point`; false if it ends there.
inline bool bounce_off(const PathContext& c, const SurfacePoint& point, const BsdfSample& next, float worth,
                       PathState& state) {
  if (!(next.pdf > 0) || !(max_component(next.value) > 0)) return false;
  state.throughput *= next.value / next.pdf;
  state.bsdf_pdf = next.pdf;
  state.lights_worth = next.is_hidden_highlight ? 1 : worth;
  state.diffuse_ancestor |= next.is_diffuse;
  ++state.bounce;
  state.ray = {ray_origin(c.scene, point.position, point.ng, next.wi), next.wi};
  return true;
}

/// Whether a path ends at this surface, and leaves all to the lights' own directions.
template <class Bsdf>
bool ends_at(const PathContext& c, const PathState& state, const Bsdf& bsdf) {
  return c.ends_at_rough_surfaces && state.bounce == c.max_bounces && bsdf.is_rough();
}

/// Where a walk goes under the surface, and where it goes on from its exit.
struct WalkNumbers {
  Vec2f entry, direction;
  LightNumbers light;
  explicit WalkNumbers(PathSampler& sampler)
      : entry(sampler.next_pair()),
        direction(sampler.next_pair()),
        light{sampler.next_pair(), sampler.next_pair().x} {}
};

/// Under the surface and out again, where the lights are asked; false if the path ends in between. Walk k of
/// n shares its numbers with the others: a lattice, so that they spread.
template <bool kCutouts, class Bsdf>
bool walk(const PathContext& c, const SurfacePoint& entry, const Bsdf& entry_bsdf, uint32_t triangle,
          const WalkMedium& medium, const WalkNumbers& numbers, int k, int n, Random& random, Tile& tile,
          std::vector<Vec3f>& radiance, PathState& state) {
  const Vec3f inwards = entry_bsdf.entry_direction(lattice_point(numbers.entry, k, n));
  WalkExit exit;
  if (!walk_under_surface<kCutouts>(c.scene, entry, triangle, medium, entry_bsdf.entry_axis(), inwards,
                                    random, tile.rays, exit))
    return false;
  state.throughput *= entry_bsdf.entry_weight() * exit.weight;
  const SurfacePoint point = surface_at(c.scene, exit.hit, exit.direction);
  const Bsdf bsdf = exit_bsdf_at<Bsdf>(point, exit.direction);
  const bool ends = ends_at(c, state, bsdf);
  const Split split = ends ? Split::none() : Split();
  sample_lights<kCutouts>(c, point, bsdf, state.throughput, numbers.light.of(k, n), split, tile, radiance);
  if (ends) return false;
  const Vec2f u = lattice_point(numbers.direction, k, n);
  return bounce_off(c, point, bsdf.sample(0, u.x, u.y), split.worth, state);
}

/// Paths that left the first surface and still have a way to go.
struct Branches {
  PathState states[std::max({kWalks, kReflections, kNarrowReflections})];
  int count = 0;
};

/// One surface: false if the path ends there. At the first, several reflections are followed, or one and
/// several walks under it, with which it does not compete: all but the last of them from `branches` on.
template <bool kCutouts, class Bsdf>
bool scatter(const PathContext& c, const Hit& hit, PathState& state, Branches& branches, PathSampler& sampler,
             Tile& tile, std::vector<Vec3f>& radiance) {
  const Vec3f wo = -state.ray.direction;
  const SurfacePoint point = surface_at(c.scene, hit, wo);
  const bool is_first = state.bounce == 0;
  UnderSurface under = UnderSurface::kNone;
  if (c.subsurface && point.texel.sss > cycles::kLeastSubsurface)
    under = state.diffuse_ancestor ? UnderSurface::kDiffuse : UnderSurface::kWalk;
  const Bsdf bsdf = bsdf_at<Bsdf>(point, wo, is_first, under);
  if (bsdf.is_black()) return false;
  const Vec2f along = sampler.next_pair(), across_and_lobe = sampler.next_pair(), u = sampler.next_pair();
  const bool ends = ends_at(c, state, bsdf);
  const bool splits = is_first && under != UnderSurface::kWalk;
  Split split = splits ? Split::of_first(c.lights.environments.size(), bsdf.is_rough()) : Split();
  if (ends) split = {split.shadow_rays, 0, Split::none().worth};
  sample_lights<kCutouts>(c, point, bsdf, state.throughput, {along, across_and_lobe.x}, split, tile,
                          radiance);
  if (ends && under != UnderSurface::kWalk) return false;
  if (splits) {
    for (int k = 0; k < split.reflections; ++k) {
      const Vec2f direction = lattice_point(u, k, split.reflections);
      const float lobe = (static_cast<float>(k) + across_and_lobe.y) / static_cast<float>(split.reflections);
      PathState& one = branches.states[branches.count];
      one = state;
      one.throughput *= 1 / static_cast<float>(split.reflections);
      branches.count += bounce_off(c, point, bsdf.sample(lobe, direction.x, direction.y), split.worth, one);
    }
    return false;
  }
  const BsdfSample next = bsdf.sample(across_and_lobe.y, u.x, u.y);
  if (under == UnderSurface::kWalk && is_first) {
    const WalkMedium medium(point.texel);
    const WalkNumbers numbers(sampler);
    for (int k = 0; k < kWalks; ++k) {
      PathState& one = branches.states[branches.count];
      one = state;
      one.throughput *= 1.0f / kWalks;
      branches.count += walk<kCutouts>(c, point, bsdf, hit.triangle, medium, numbers, k, kWalks,
                                       sampler.random, tile, radiance, one);
    }
    return !ends && !next.enters && bounce_off(c, point, next, split.worth, state);
  }
  if (next.enters) {
    // The walk's medium has the colour: the lobe's weight is only its share.
    state.throughput *= 1 / next.pdf;
    return walk<kCutouts>(c, point, bsdf, hit.triangle, WalkMedium(point.texel), WalkNumbers(sampler), 0, 1,
                          sampler.random, tile, radiance, state);
  }
  return !ends && bounce_off(c, point, next, split.worth, state);
}

/// To the next surface and on from it: false if the path ends.
template <bool kCutouts, class Bsdf>
bool advance(const PathContext& c, PathState& state, Branches& branches, PathSampler& sampler, Tile& tile,
             std::vector<Vec3f>& radiance) {
  Hit hit;
  if (!intersect<kCutouts>(c.scene, state.ray, sampler.random, tile.rays, hit)) {
    add_environments(c, state.ray.direction, state.bsdf_pdf, state.lights_worth, state.throughput, tile,
                     radiance);
    return false;
  }
  if (state.bounce > c.max_bounces) return false;
  if (state.bounce >= kRouletteFromBounce) {
    const float survive = std::fmin(1.0f, std::sqrt(max_component(state.throughput)));
    if (!(sampler.random.next() < survive)) return false;
    state.throughput *= 1 / survive;
  }
  return scatter<kCutouts, Bsdf>(c, hit, state, branches, sampler, tile, radiance);
}

/// Camera rays of one pixel and what they meet.
struct CameraRays {
  static constexpr int kMost = 8;
  Ray rays[kMost];
  Hit hits[kMost];
  bool is_hit[kMost];
  std::vector<PathSampler> samplers;  // one a ray

  /// Without cut-outs all at once, and what shading will ask for first comes into the cache meanwhile.
  template <bool kCutouts>
  void intersect_all(const Scene& scene, RayCounts& counts) {
    const int count = static_cast<int>(samplers.size());
    if (kCutouts || count < 2) {
      for (int i = 0; i < count; ++i)
        is_hit[i] =
            intersect<kCutouts>(scene, rays[i], samplers[static_cast<size_t>(i)].random, counts, hits[i]);
      return;
    }
    counts.closest_hit += static_cast<uint64_t>(count);
    for (int i = 0; i < count; ++i)
      record_ray(counts, rays[i], 0, std::numeric_limits<float>::infinity(), false, false);
    const uint32_t met = scene.opaque ? intersect_eight_rays(scene.opaque, rays, count, hits) : 0;
    for (int i = 0; i < count; ++i) {
      is_hit[i] = met >> i & 1;
      if (is_hit[i]) prefetch_surface(scene, hits[i]);
    }
    for (int i = 0; i < count; ++i)
      if (is_hit[i]) prefetch_texels(scene, hits[i]);
  }
};

/// A path from what a camera ray met.
template <bool kCutouts, class Bsdf>
void trace_path(const PathContext& c, const Ray& camera_ray, const Hit& hit, PathSampler& sampler, Tile& tile,
                std::vector<Vec3f>& radiance) {
  PathState state;
  Branches branches;
  state.ray = camera_ray;
  bool goes_on = scatter<kCutouts, Bsdf>(c, hit, state, branches, sampler, tile, radiance);
  while (goes_on || branches.count > 0) {
    if (!goes_on) state = branches.states[--branches.count];
    goes_on = advance<kCutouts, Bsdf>(c, state, branches, sampler, tile, radiance);
  }
}

// Compiled apart, in path_tracer_v2.cpp: in one unit the compiler inlines less of each model.
extern template void trace_path<false, PrincipledV2>(const PathContext&, const Ray&, const Hit&, PathSampler&,
                                                     Tile&, std::vector<Vec3f>&);
extern template void trace_path<true, PrincipledV2>(const PathContext&, const Ray&, const Hit&, PathSampler&,
                                                    Tile&, std::vector<Vec3f>&);

}  // namespace ohb
