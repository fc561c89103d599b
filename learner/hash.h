// Random numbers as a function of what they are for (seed, epoch, position, ...), never of time or thread.
#pragma once

#include <cstdint>
#include <initializer_list>

#include "dataset/model/mix_bits.h"

namespace ohb::learner {

/// One key from several numbers, in order.
inline uint64_t key_of(std::initializer_list<uint64_t> parts) {
  uint64_t key = 0;
  for (const uint64_t part : parts) key = split_mix(key ^ split_mix(part));
  return key;
}

/// Uniform in [0, 1): number `index` of the stream `key`.
inline double uniform_of(uint64_t key, uint64_t index) {
  return static_cast<double>(split_mix(key ^ split_mix(index)) >> 11) * 0x1.0p-53;
}

}  // namespace ohb::learner
