// One path serves all lights: the way through the scene does not depend on them, so each vertex asks every
// light for its share (next-event estimation), and a ray that leaves the scene asks every environment.
// The estimate of light l is a sum over path vertices of
//   throughput x [ f cos L_l(wi) V / pdf_l  w(pdf_l, pdf_bsdf)            (light sampling)
//               or f cos L_l(wi) / pdf_bsdf w(pdf_bsdf, pdf_l) ]           (BSDF sampling)
// with w the power heuristic between that light's own density and the BSDF's: unbiased for each light alone.
#pragma once

#include "renderer/path_state.h"
#include "renderer/surface.h"

namespace ohb::renderer {

/// A surface at which a path asks the lights (next-event estimation).
template <class Bsdf>
struct LightQuery {
  const SurfacePoint& point;
  const Bsdf& bsdf;
  Vec3f throughput;
  const Split& split;
  ShadowGuess* guess = nullptr;  // null: none
};

/// What each of eight directions that an environment suggests would bring if nothing stood between, weighted
/// by the power heuristic over its pdf; 0 where the environment is black.
template <class Bsdf>
Vec3f8 unshadowed(const LightCandidates& candidates, const LightQuery<Bsdf>& at) {
  const auto eight = [](const float* values) { return Float8(values, stdx::vector_aligned); };
  const Vec3f8 wi{eight(candidates.wi_x), eight(candidates.wi_y), eight(candidates.wi_z)};
  const Vec3f8 light{eight(candidates.red), eight(candidates.green), eight(candidates.blue)};
  const Float8 pdf = eight(candidates.pdf);
  const BsdfValue8 f = at.bsdf.eval(wi);
  const Float8 ratio = f.pdf / (at.split.worth * pdf), scale = 1 / (pdf * (1 + ratio * ratio));
  const Float8 zero = 0;
  const Mask8 shines = pdf > zero;
  const auto shining = [&](Float8 v) { return select(shines, v, zero); };
  const Vec3f throughput = at.throughput / static_cast<float>(at.split.groups);
  return {shining(throughput.x * f.value.x * light.x * scale),
          shining(throughput.y * f.value.y * light.y * scale),
          shining(throughput.z * f.value.z * light.z * scale)};
}

/// Shadow rays towards an environment's directions wait in the tile. How many is `rays`, which ones their
/// `weight` (resampled importance sampling, Talbot et al. 2005, equation 6), by steps of equal weight from a
/// random start.
struct ShadowChoice {
  const LightCandidates& candidates;
  const Vec3f8& value;
  Float8 weight, expected_share;
  float rays;
};
template <class Bsdf>
void choose_shadow_rays(const PathContext& c, size_t l, const LightQuery<Bsdf>& at, float u,
                        const ShadowChoice& choice, Tile& tile) {
  constexpr int kCount = LightCandidates::kCount;
  const auto& [candidates, value, weight, expected_share, rays] = choice;
  const float doubted = stdx::reduce(weight), step = doubted / rays;
  float place = u * step;
  if (!(step > 0) || place >= doubted) return;  // 0: below what a float holds
  alignas(32) float sums[kCount];
  float sum = 0;
  for (int k = 0; k < kCount; ++k) sums[k] = sum += weight[k];
  const Float8 steps(sums, stdx::vector_aligned);
  for (; place < sum; place += step) {
    const int chosen = std::min(stdx::popcount(steps <= Float8(place)), kCount - 1);
    const float chosen_weight = weight[chosen];
    if (!(chosen_weight > 0)) continue;
    const Vec3f chosen_wi{candidates.wi_x[chosen], candidates.wi_y[chosen], candidates.wi_z[chosen]};
    const Vec3f chosen_value{value.x[chosen], value.y[chosen], value.z[chosen]};
    tile.waiting.push_back({{ray_origin(c.scene, at.point.position, at.point.ng, chosen_wi), chosen_wi},
                            std::numeric_limits<float>::infinity(),
                            chosen_value * (step / (chosen_weight * static_cast<float>(kCount))),
                            static_cast<uint32_t>(l),
                            expected_share[chosen],
                            at.guess ? &at.guess->at(candidates.cell[chosen]) : nullptr});
  }
}

/// What is expected to arrive from the directions that environment `l` suggests, which is added to `arrives`,
/// and shadow rays to some of them, chosen by how far off that may be; where nothing is expected, by what
/// they would bring.
template <class Bsdf>
void sample_environment(const PathContext& c, size_t l, const LightQuery<Bsdf>& at, const LightNumbers& u,
                        Vec3f8& arrives, Tile& tile) {
  const LightCandidates& candidates = tile.pools[l].at({u.along.y, u.across});
  const Vec3f8 value = unshadowed(candidates, at);
  const Float8 size = (value.x + value.y + value.z) * (1.0f / 3);
  const float whole = stdx::reduce(size);
  if (!std::isfinite(whole)) ++tile.nonfinite;
  if (!(whole > 0) || !std::isfinite(whole)) return;
  float rays = static_cast<float>(at.split.picks);
  Expected8 expected;
  if (at.guess) {
    expected = at.guess->expect(candidates.cell);
    arrives = {arrives.x + expected.share * value.x, arrives.y + expected.share * value.y,
               arrives.z + expected.share * value.z};
  }
  const Float8 weight = size * expected.doubt;
  const float doubted = stdx::reduce(weight);
  if (!(doubted > 0)) return;
  if (at.guess) rays *= ShadowGuess::rays(doubted / whole);
  choose_shadow_rays(c, l, at, u.along.x, {candidates, value, weight, expected.share, rays}, tile);
}

/// Asks every light: their shadow rays wait in the tile.
template <class Bsdf>
void sample_lights(const PathContext& c, const LightQuery<Bsdf>& at, const LightNumbers& u, Tile& tile) {
  // One set of numbers for all lights: each light's image is unbiased by itself.
  for (size_t l = 0; l < c.lights.environments.size(); ++l) {
    Vec3f8 arrives{0, 0, 0};
    for (int k = 0; k < at.split.groups; ++k)
      sample_environment(c, l, at, u.spread(k, at.split.groups), arrives, tile);
    if (at.guess)
      add(Vec3f{stdx::reduce(arrives.x), stdx::reduce(arrives.y), stdx::reduce(arrives.z)} /
              static_cast<float>(LightCandidates::kCount),
          tile.radiance[l], tile);
  }
  for (size_t i = 0; i < c.lights.points.size(); ++i) {
    const PointLight& light = c.lights.points[i];
    const Vec3f to_light = turn_about_y(light.position_cm, -c.turn_rad) - at.point.position;
    const float distance_cm = length(to_light);
    if (!(distance_cm > 0)) continue;
    const Vec3f wi = to_light / distance_cm;
    const BsdfValue f = at.bsdf.eval(wi);
    if (!(max_component(f.value) > 0)) continue;
    const float distance_m = distance_cm * 0.01f;
    tile.waiting.push_back({{ray_origin(c.scene, at.point.position, at.point.ng, wi), wi},
                            distance_cm,
                            at.throughput * f.value * (light.intensity / (distance_m * distance_m)),
                            static_cast<uint32_t>(c.lights.environments.size() + i),
                            0,
                            nullptr});
  }
}

/// The shadow rays of what waits, eight at once: they start close to each other.
template <bool kCutouts>
void ask_shadows(const PathContext& c, Tile& tile) {
  float shares[8];
  for (size_t i = 0; i < tile.waiting.size(); i += 8) {
    const WaitingLight* lights = &tile.waiting[i];
    const int count = static_cast<int>(std::min<size_t>(8, tile.waiting.size() - i));
    transmittances<kCutouts>(c.scene, lights, count, tile.rays, shares);
    for (int k = 0; k < count; ++k) {
      if (lights[k].seen) lights[k].seen->add(shares[k]);
      const float unexpected = shares[k] - lights[k].expected;
      if (unexpected != 0) add(unexpected * lights[k].value, tile.radiance[lights[k].light], tile);
    }
  }
  tile.waiting.clear();
}

inline void add_environments(const PathContext& c, const PathState& state, MapPlace place, Tile& tile) {
  for (size_t l = 0; l < c.lights.environments.size(); ++l) {
    const EnvironmentValue value = c.lights.environments[l].at(place);
    const float weight = power_heuristic(state.bsdf_pdf, state.lights_worth * value.pdf);
    add(weight * value.radiance * state.throughput, tile.radiance[l], tile);
  }
}

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

/// A path goes under the surface; where it comes out again is up to leave_walks().
template <class Bsdf>
void begin_walk(const SurfacePoint& entry, const Bsdf& bsdf, const WalkMedium& medium,
                const WalkingPath& path, Tile& tile) {
  const Vec3f inwards = bsdf.entry_direction(lattice_point(path.numbers.entry, path.k, path.n));
  tile.walks.push_back({entry.position, entry.ng, bsdf.entry_axis(), inwards, entry.hit.triangle, &medium,
                        path.state.random.branch(static_cast<uint64_t>(path.k))});
  tile.walking.push_back(path);
  tile.walking.back().state.throughput *= bsdf.entry_weight();
}

/// Branch k of the n that a path splits into at the first surface.
inline PathState branch_of(const PathState& state, int number, int n) {
  PathState one = state;
  one.throughput *= 1 / static_cast<float>(n);
  one.random = state.sampler->random.branch(static_cast<uint64_t>(number));
  return one;
}

/// The reflections of a path at the first surface, all drawn at once.
template <class Bsdf>
void reflect_first(const PathContext& c, const LightQuery<Bsdf>& at, float lobe, Vec2f u,
                   const PathState& state, Tile& tile) {
  static_assert(std::max({kRoughReflections, kNarrowReflections, kWalkReflections}) <= 8);
  float lobes[8];
  Vec2f directions[8];
  BsdfSample next[8];
  const int count = at.split.reflections;
  for (int k = 0; k < count; ++k) {
    directions[k] = lattice_point(u, k, count);
    lobes[k] = (static_cast<float>(k) + lobe) / static_cast<float>(count);
  }
  if (count > 0) at.bsdf.sample(count, lobes, directions, next);
  for (int k = 0; k < count; ++k) {
    PathState one = branch_of(state, k, count);
    if (!next[k].enters && bounce_off(c, at.point, next[k], at.split.worth, one)) tile.next.push_back(one);
  }
}

/// What leaves the first surface: to the lights, by reflection, and by walks under it, with which reflections
/// do not compete.
template <class Bsdf>
void fan_out(const PathContext& c, const SurfacePoint& point, const Bsdf& bsdf, bool walks_under,
             const PathState& state, Tile& tile) {
  PathSampler& sampler = *state.sampler;
  const Vec2f along = sampler.next_pair(), across_and_lobe = sampler.next_pair(), u = sampler.next_pair();
  Split split = Split::of_first(c.lights.environments.size(), bsdf.is_rough(), walks_under);
  const bool ends = ends_at(c, state, bsdf);
  if (ends) split = split.without_reflections();
  const LightQuery<Bsdf> query{point, bsdf, state.throughput, split, tile.guess};
  sample_lights(c, query, {along, across_and_lobe.x}, tile);
  reflect_first(c, query, across_and_lobe.y, u, state, tile);
  if (!walks_under) return;
  const WalkMedium& medium = tile.media.emplace_back(point.texel);
  const WalkNumbers numbers(sampler);
  for (int k = 0; k < split.walks; ++k)
    begin_walk(point, bsdf, medium,
               {branch_of(state, split.reflections + k, split.walks), numbers, k, split.walks}, tile);
}

/// One surface: what goes on from there comes into tile.next and tile.walks.
template <class Bsdf>
void scatter(const PathContext& c, const Hit& hit, PathState& state, Tile& tile) {
  const Vec3f wo = -state.ray.direction;
  const SurfacePoint point = surface_at(c.scene, hit, wo);
  const bool is_first = state.bounce == 0;
  UnderSurface under = UnderSurface::kNone;
  if (c.subsurface && point.texel.sss > cycles::kLeastSubsurface)
    under = state.diffuse_ancestor ? UnderSurface::kDiffuse : UnderSurface::kWalk;
  const bool walks_under = under == UnderSurface::kWalk;
  const Bsdf bsdf = bsdf_at<Bsdf>(point, wo, is_first, under);
  if (bsdf.is_black()) return;
  if (is_first) {
    fan_out(c, point, bsdf, walks_under, state, tile);
    return;
  }
  Random& random = state.random;
  const Vec2f along = random.next_pair(), across_and_lobe = random.next_pair(), u = random.next_pair();
  const bool ends = ends_at(c, state, bsdf);
  const Split split = ends ? Split().without_reflections() : Split();
  sample_lights(c, LightQuery<Bsdf>{point, bsdf, state.throughput, split}, {along, across_and_lobe.x}, tile);
  if (ends && !walks_under) return;
  const BsdfSample next = bsdf.sample(across_and_lobe.y, u.x, u.y);
  if (next.enters) {
    // The walk's medium has the colour: the lobe's weight is only its share.
    state.throughput *= 1 / next.pdf;
    const WalkNumbers numbers(random);
    begin_walk(point, bsdf, tile.media.emplace_back(point.texel), {state, numbers, 0, 1}, tile);
  } else if (!ends && bounce_off(c, point, next, split.worth, state)) {
    tile.next.push_back(state);
  }
}

}  // namespace ohb::renderer
