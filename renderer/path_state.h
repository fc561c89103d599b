// What a path carries from surface to surface, and what the paths of one tile share.
#pragma once

#include <algorithm>
#include <deque>
#include <limits>
#include <vector>

#include "renderer/lights.h"
#include "renderer/random_walk.h"
#include "renderer/shadow_guess.h"

namespace ohb::renderer {

constexpr float kCandidatesWorth = 3;  // in directions of the BSDF's own, measured; any value is unbiased
// The first surface that the camera sees sends several rays on, which share the way to it: so many at rough
// surfaces, at those with narrow highlights, which find them by reflections, and where walks go under the
// surface. Measured.
constexpr int kRoughGroups = 4, kNarrowGroups = 2, kWalkGroups = 2;  // of candidates of each environment
constexpr int kPicks = 2, kPicksOfMany = 1;                          // shadow rays to each of them
constexpr int kRoughReflections = 3, kNarrowReflections = 4, kWalkReflections = 4;
constexpr int kWalks = 12;
constexpr int kRouletteFromBounce = 2;  // Cycles: the continuation test starts at the third surface

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
  LightNumbers spread(int k, int n) const {
    constexpr float kThirdStep = 0.7548777f;  // of the plastic number: unlike kLatticeStep
    return {lattice_point(along, k, n), fraction_of(across + static_cast<float>(k) * kThirdStep)};
  }
};

/// Where a walk goes under the surface, and where it goes on from its exit.
struct WalkNumbers {
  Vec2f entry, direction;
  LightNumbers light;
  template <class Numbers>
  explicit WalkNumbers(Numbers& numbers)
      : entry(numbers.next_pair()),
        direction(numbers.next_pair()),
        light{numbers.next_pair(), numbers.next_pair().x} {}
};

/// What a path carries from one surface to the next.
struct PathState {
  explicit PathState(PathSampler& camera_sampler) : sampler(&camera_sampler), random(camera_sampler.random) {}

  Ray ray;
  PathSampler* sampler;  // up to the first surface
  Random random;         // from there on its own: what one ray draws does not change what its neighbours do
  Vec3f throughput{1, 1, 1};
  float bsdf_pdf = 0;
  float lights_worth = 0;  // of the environments' directions against this one
  int bounce = 0;
  bool diffuse_ancestor = false;  // walks are made before the first diffuse bounce only
};

/// Where a ray of a wave went.
struct Arrival : Found {
  MapPlace place;  // in the environments, where there is no hit
};

/// A path under the surface. Walk k of n shares its numbers with the others: a lattice, so that they spread.
struct WalkingPath {
  PathState state;
  WalkNumbers numbers;
  int k, n;
};

/// What the paths of one tile share, and what they did.
struct Tile {
  const LightPool* pools = nullptr;   // one an environment
  std::vector<WaitingLight> waiting;  // of the pixel at work
  std::vector<PathState> next;        // rays of the pixel at work that are to be traced
  std::vector<PathState> wave;        // that are at their surfaces
  std::vector<Arrival> arrivals;      // of `wave`
  std::vector<Walk> walks;            // that `wave` began
  std::vector<WalkingPath> walking;   // who makes them
  std::deque<WalkMedium> media;       // that they go through
  Vec3f* radiance = nullptr;          // of the pixel at work, one a light
  ShadowGuess* guess = nullptr;       // of the pixel at work; null: none
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

inline void add(Vec3f contribution, Vec3f& sum, Tile& tile) {
  if (is_finite(contribution))
    sum += contribution;
  else
    ++tile.nonfinite;
}

/// How many rays leave a surface, and how they count.
struct Split {
  int groups = 1;  // of candidates of each environment that are asked
  int picks = 1;   // shadow rays to each group
  int reflections = 1;
  int walks = 1;
  /// How much all directions that an environment suggests count in the heuristic against one that the BSDF
  /// draws; infinite where it draws none.
  float worth = kCandidatesWorth;

  Split without_reflections() const {
    return {groups, picks, 0, walks, std::numeric_limits<float>::infinity()};
  }
  /// At the first surface.
  static Split of_first(size_t environments, bool is_rough, bool walks_under) {
    Split split;
    split.groups = walks_under ? kWalkGroups : is_rough ? kRoughGroups : kNarrowGroups;
    split.picks = environments <= 1 ? kPicks : kPicksOfMany;
    split.reflections = walks_under ? kWalkReflections : is_rough ? kRoughReflections : kNarrowReflections;
    split.walks = kWalks;
    split.worth *= static_cast<float>(split.groups * split.picks) / static_cast<float>(split.reflections);
    return split;
  }
};

}  // namespace ohb::renderer
