// Rays of many paths of a pixel, traced and then shaded together, surface by surface: Embree takes eight at
// once, and what shading reads is on its way to the cache before it is asked for.
#pragma once

#include "renderer/path_tracer.h"

namespace ohb::renderer {

/// Where the rays of tile.wave go, without cut-outs eight at once. What is asked for there comes into the
/// cache meanwhile: texels of large maps come from far.
template <bool kCutouts>
void trace_wave(const PathContext& c, Tile& tile) {
  const size_t count = tile.wave.size();
  tile.arrivals.resize(count);
  if constexpr (kCutouts) {
    for (size_t i = 0; i < count; ++i)
      tile.arrivals[i].is_hit =
          intersect<true>(c.scene, tile.wave[i].ray, tile.wave[i].random, tile.rays, tile.arrivals[i].hit);
  } else {
    for (size_t i = 0; i < count; i += 8) {
      const PathState* paths = &tile.wave[i];
      closest_opaque(
          c.scene, static_cast<int>(std::min<size_t>(8, count - i)),
          [&](int k) -> const Ray& { return paths[k].ray; }, paths->bounce == 0, tile.rays,
          &tile.arrivals[i]);
    }
  }
  for (size_t i = 0; i < count; ++i) {
    Arrival& arrival = tile.arrivals[i];
    if (arrival.is_hit) {
      prefetch_surface(c.scene, arrival.hit);
    } else if (tile.wave[i].bounce > 0) {
      arrival.place = map_place(c.to_world(tile.wave[i].ray.direction));
      for (const EnvironmentLight& light : c.lights.environments) light.prefetch(arrival.place);
    }
  }
  for (const Arrival& arrival : tile.arrivals)
    if (arrival.is_hit) prefetch_texels(c.scene, arrival.hit);
}

/// A path at the end of its ray.
template <class Bsdf>
void arrive(const PathContext& c, const Arrival& arrival, PathState& state, Tile& tile) {
  if (!arrival.is_hit) {
    // The camera sees no background: it is transparent.
    if (state.bounce > 0) add_environments(c, state, arrival.place, tile);
    return;
  }
  if (state.bounce > c.max_bounces) return;
  if (state.bounce >= kRouletteFromBounce) {
    const float survive = std::fmin(1.0f, std::sqrt(max_component(state.throughput)));
    if (!(state.random.next() < survive)) return;
    state.throughput *= 1 / survive;
  }
  scatter<Bsdf>(c, arrival.hit, state, tile);
}

/// All walks to their ends; those that come out ask the lights there and go on.
template <bool kCutouts, class Bsdf>
void leave_walks(const PathContext& c, Tile& tile) {
  walk_under_surface<kCutouts>(c.scene, tile.walks, tile.rays);
  for (const Walk& walk : tile.walks)
    if (walk.is_out) prefetch_surface(c.scene, walk.exit.hit);
  for (const Walk& walk : tile.walks)
    if (walk.is_out) prefetch_texels(c.scene, walk.exit.hit);
  for (size_t i = 0; i < tile.walks.size(); ++i) {
    const WalkExit& exit = tile.walks[i].exit;
    WalkingPath& path = tile.walking[i];
    if (!tile.walks[i].is_out) continue;
    path.state.throughput *= exit.weight;
    const SurfacePoint point = surface_at(c.scene, exit.hit, exit.direction);
    const Bsdf bsdf = exit_bsdf_at<Bsdf>(point, exit.direction);
    const bool ends = ends_at(c, path.state, bsdf);
    const Split split = ends ? Split().without_reflections() : Split();
    const LightQuery<Bsdf> query{point, bsdf, path.state.throughput, split,
                                 path.state.bounce == 0 ? tile.guess : nullptr};
    sample_lights(c, query, path.numbers.light.spread(path.k, path.n), tile);
    const Vec2f u = lattice_point(path.numbers.direction, path.k, path.n);
    if (!ends && bounce_off(c, point, bsdf.sample(0, u.x, u.y), split.worth, path.state))
      tile.next.push_back(path.state);
  }
  tile.walks.clear(), tile.walking.clear(), tile.media.clear();
}

/// The paths of one pixel's camera rays in tile.next to their ends, surface by surface all together, added to
/// tile.radiance.
template <bool kCutouts, class Bsdf>
void trace_paths(const PathContext& c, Tile& tile) {
  while (!tile.next.empty()) {
    tile.wave.swap(tile.next);
    tile.next.clear();
    trace_wave<kCutouts>(c, tile);
    for (size_t i = 0; i < tile.wave.size(); ++i) arrive<Bsdf>(c, tile.arrivals[i], tile.wave[i], tile);
    if (!tile.walks.empty()) leave_walks<kCutouts, Bsdf>(c, tile);
  }
  ask_shadows<kCutouts>(c, tile);
}

// Compiled apart, in path_tracer_v2.cpp: in one unit the compiler inlines less of each model.
extern template void trace_paths<false, PrincipledV2>(const PathContext&, Tile&);
extern template void trace_paths<true, PrincipledV2>(const PathContext&, Tile&);

}  // namespace ohb::renderer
