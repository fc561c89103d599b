// How many paths each pixel gets.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/sample.h"

namespace ohb::renderer {

/// Independent images of the same number of paths a seen pixel, and what they took.
struct Pilots {
  std::vector<std::vector<SampleLight>> images;  // [image][light]
  std::vector<float> work;                       // of each pixel, in any unit; empty: the same for all
};

/// Paths of each pixel of a square image so that the sum is about mean_spp times the seen pixels and the mean
/// squared error is least for the work: in proportion to the standard deviation of one path over the root of
/// its cost (Neyman 1934, with costs), which the pilots estimate, pooled over the pixel and its neighbours (a
/// Gaussian of one pixel). Several lights count by their relative variance. No seen pixel gets less than a
/// quarter of the mean: a pilot may have missed what is rare. `seen` as of footprint().
std::vector<uint32_t> adaptive_budget(const Pilots& pilots, const std::vector<uint8_t>& seen, int size_px,
                                      double mean_spp);

/// The four classes of pixels that take turns in every row and column.
constexpr int kPixelClasses = 4;
constexpr int pixel_class(int x, int y) {
  return (x & 1) | (y & 1) << 1;
}

/// The same where the first begun_spp paths of each pixel are made and stay: none below that. `begun` are
/// consecutive equal parts of them. What a pixel gets is a function of the other classes' pixels alone (each
/// class has its own sum), so it does not depend on its own paths and the mean of all of them is unbiased, as
/// long as classes share no random numbers.
std::vector<uint32_t> continued_budget(const Pilots& begun, uint32_t begun_spp,
                                       const std::vector<uint8_t>& seen, int size_px, double mean_spp);

}  // namespace ohb::renderer
