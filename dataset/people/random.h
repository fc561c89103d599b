// Random numbers that are a function of their key, with the same bits everywhere.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "dataset/model/mix_bits.h"

namespace ohb::people {

/// A stream of numbers for one purpose: each trait of a person has its own, so that a new trait changes no
/// other.
class Random {
 public:
  Random(uint64_t key, std::string_view purpose) : state_(split_mix(key)) {
    for (const char c : purpose) state_ = split_mix(state_ ^ static_cast<unsigned char>(c));
  }
  uint64_t next() { return state_ = split_mix(state_); }
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
