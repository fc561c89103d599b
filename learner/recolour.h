// Other colours for the same person: what keeps a network that has seen few people from taking the colours of
// their clothes for their materials. Not in the paper.
#pragma once

#include <cstdint>

#include "learner/data.h"

namespace ohb::learner {

/// Another albedo under the same light, in place: `e.truth.diffuse` and the colours of `e.input` are
/// multiplied by the same factors, in linear light; all other maps stay.
///
/// What scatters below the surface (skin) gets one factor for its lightness and a slight one a channel: skin
/// has few hues. All else has its channels exchanged, and a factor a channel that grows or falls with the
/// roughness, so that hair, fabric and leather change differently while soft borders stay soft. Albedo stays
/// within [0, 0.95]. The picture is then exposed anew as example_of exposes it. Exact for light that the
/// albedo reflected once; highlights and interreflections are scaled with it.
/// A function of e and key; e is a batch of one.
void recolour(Example& e, uint64_t key);

}  // namespace ohb::learner
