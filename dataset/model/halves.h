// Half floats of many values at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ohb {

constexpr float kLargestHalf = 65504.0f;

/// Rounded to the nearest, to even in the middle. Values beyond a half's range are clamped to it: infinities
/// would come of them. NaN stays NaN. All threads.
std::vector<uint16_t> halves_of(const float* values, size_t count);

/// The same values, exactly. One thread.
void floats_of(const uint16_t* halves, size_t count, float* values);

}  // namespace ohb
