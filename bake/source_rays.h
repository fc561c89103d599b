// Which point of the source a point of the low mesh shows.
#pragma once

#include <cstdint>

#include "bake/source_surface.h"

namespace ohb::bake {

enum class RayResult : uint8_t {
  kNoFace,    // the texel shows no face of the low mesh
  kHit,       // a ray met the source
  kNearest,   // no ray did: the nearest point of the source that faces the same way, within the reach
  kMissed,    // nothing within the reach
  kBackFace,  // only surfaces that face the other way
};

struct SourcePoint {
  RayResult result = RayResult::kMissed;
  uint32_t triangle = 0;
  float u = 0, v = 0;     // barycentric weights of corners 1 and 2
  float distance_cm = 0;  // along the direction, positive outwards
};

/// Points of the low mesh with the outward direction (unit) in which each looks for the source: up to
/// `outward_cm` that way, up to `inward_cm` the other way.
struct RayPacket {
  static constexpr int kSize = 8;
  int count = 0;
  Vec3f origin[kSize], direction[kSize];
  float outward_cm[kSize] = {};
  float inward_cm = 0;
};

/// Two rays leave the point, outwards and inwards. The first surface on each way counts if it faces outwards;
/// one that faces the other way ends the way: behind it lies another part of the body (the far leg, the arm
/// at the side), however near. Of the two the nearer counts. Where there is none, the nearest point of the
/// source whose normal is within 60 degrees of the direction stands in, within the
/// reach and if nothing lies before it. Back faces at the
/// point itself (double-sided sheets) are passed.
void find_source(const SourceSurface& source, const RayPacket& packet, SourcePoint* points);

/// The same with one ray at a time: the slow twin.
SourcePoint find_source_of_one(const SourceSurface& source, Vec3f origin, Vec3f direction, float outward_cm,
                               float inward_cm);

}  // namespace ohb::bake
