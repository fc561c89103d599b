// How much of an even light from all around reaches each point of a mesh: what a scan's texture holds besides
// the albedo.
#pragma once

#include <vector>

#include "dataset/model/model.h"

namespace ohb::bake {

/// Irradiance at each position of the mesh, over that of an open plane (1), R, G and B: light of 1 from every
/// direction that sees the outside, and from the others what the surface there sends back.
///   E(x) = 1/pi Integral over the hemisphere of (open ? 1 : glow(y)) cos dw
/// `glow`: of each position, its radiosity in the same light (albedo times E there: just what a texture with
/// baked shading shows); so one bounce holds all. `rays` cosine-weighted directions a position (Hammersley's
/// points, turned by a sequence over the positions: Roberts 2018), about the smooth normal. `occludes`: one a
/// triangle. The result does not depend on the number of threads.
std::vector<Vec3f> ambient_irradiance(const Model& mesh, const std::vector<uint8_t>& occludes,
                                      const std::vector<Vec3f>& glow, int rays);

}  // namespace ohb::bake
