// Random numbers that are a function of their key, with the same bits everywhere.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace ohb::people {

/// SplitMix64 (Steele, Lea and Flood 2014).
inline uint64_t mixed(uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// A stream of numbers for one purpose: each trait of a person has its own, so that a new trait changes no
/// other.
class Random {
 public:
  Random(uint64_t key, std::string_view purpose) : state_(mixed(key)) {
    for (const char c : purpose) state_ = mixed(state_ ^ static_cast<unsigned char>(c));
  }
  uint64_t next() { return state_ = mixed(state_); }
  /// [0, 1), a multiple of 2^-24.
  float unit() { return static_cast<float>(next() >> 40) * 0x1p-24f; }
  float within(float low, float high) { return low + (high - low) * unit(); }
  /// Below `count` (at least 1).
  size_t below(size_t count) { return static_cast<size_t>(next() >> 32) % count; }
  bool chance(float share) { return unit() < share; }
  /// Mean 0, deviation 1, within 3: the sum of twelve numbers (no logarithm, whose bits differ).
  float normal() {
    float sum = -6;
    for (int i = 0; i < 12; ++i) sum += unit();
    return sum < -3 ? -3 : sum > 3 ? 3 : sum;
  }
  template <typename T>
  const T& pick(const std::vector<T>& list) {
    return list[below(list.size())];
  }

 private:
  uint64_t state_;
};

}  // namespace ohb::people
