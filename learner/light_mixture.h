// More lights than were rendered: light transport is linear in them.
#pragma once

#include <cstdint>

#include "dataset/model/sample.h"

namespace ohb::learner {

/// One light of a sample, a function of `key`. In half of the cases one of its own; else two of them, which
/// may be the same, each brought to the same mean over the foreground and given a colour of its own, up to
/// half a stop either way a channel, in a proportion drawn evenly. Exact: what a scene shows under the sum of
/// two lights is the sum of what it shows under each, and radiance is proportional to the light's, a channel
/// at a time. Throws nothing; the sample has a light.
SampleLight mixed_light(const Sample& sample, uint64_t key);

}  // namespace ohb::learner
