// Bits of numbers scattered: what every key of random numbers is made with (SplitMix64; Steele, Lea and Flood
// 2014).
#pragma once

#include <cstdint>

namespace ohb {

/// The finaliser: a bijection in which each bit reaches all.
inline uint64_t mix_bits(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// A step of the generator from state x.
inline uint64_t split_mix(uint64_t x) {
  return mix_bits(x + 0x9e3779b97f4a7c15ull);
}

}  // namespace ohb
