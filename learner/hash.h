// Random numbers as a function of what they are for (seed, epoch, position, ...), never of time or thread.
#pragma once

#include <cstdint>
#include <initializer_list>

namespace ohb::learner {

/// SplitMix64's finaliser (Steele, Lea and Flood 2014): a bijection that scatters every bit.
inline uint64_t mixed(uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// One key from several numbers, in order.
inline uint64_t key_of(std::initializer_list<uint64_t> parts) {
  uint64_t key = 0;
  for (const uint64_t part : parts) key = mixed(key ^ mixed(part));
  return key;
}

/// Uniform in [0, 1): number `index` of the stream `key`.
inline double uniform_of(uint64_t key, uint64_t index) {
  return static_cast<double>(mixed(key ^ mixed(index)) >> 11) * 0x1.0p-53;
}

}  // namespace ohb::learner
