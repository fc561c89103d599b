// What earlier shadow rays of a place found, as a guess of what the next will: light that is expected to
// arrive is added at once, and rays find out the difference (a control variate: Owen, "Monte Carlo theory,
// methods and examples", section 8.9). Unbiased whatever is guessed, since a ray's own result is not part of
// its guess; the better the guess, the fewer rays.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "renderer/direction_cells.h"
#include "renderer/eight.h"

namespace ohb::renderer {

constexpr int kGuessBlock_px = 4;  // pixels of a square that share a guess, measured

/// Shares of light that arrived along the rays of a cell of directions.
struct SeenShares {
  float sum = 0, count = 0;
  void add(float share) { sum += share, ++count; }
};

/// The share of light that is expected to arrive along each of eight directions, and its standard deviation.
struct Expected8 {
  Float8 share = 0, doubt = 1;
};

class ShadowGuess {
 public:
  SeenShares& at(int cell) { return cells_[static_cast<size_t>(cell)]; }
  /// What is expected along the directions of eight cells. Nothing is ever certain: half a ray that arrived,
  /// and half a ray that did not, count with those seen.
  Expected8 expect(const uint8_t* cells) const {
    constexpr int kCount = 8;
    alignas(32) float sums[kCount], counts[kCount];
    for (int k = 0; k < kCount; ++k) {
      const SeenShares& seen = cells_[cells[k]];
      sums[k] = seen.sum, counts[k] = seen.count;
    }
    const Float8 share =
        (Float8(sums, stdx::vector_aligned) + 0.5f) / (Float8(counts, stdx::vector_aligned) + 1);
    return {share, sqrt(share * (1 - share))};
  }
  /// Rays for each that would be sent without a guess, if what is in doubt is `doubted` of the whole.
  static float rays(float doubted) { return std::clamp(4 * doubted, 0.05f, 1.0f); }  // measured

 private:
  std::array<SeenShares, DirectionCells::kCount> cells_;
};

}  // namespace ohb::renderer
