#include "learner/conv_kernel.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#define OHB_CONV 1
#endif

namespace ohb::learner::conv_kernel {

#ifdef OHB_CONV
namespace {

/// Pixels and channels of y whose sums are twelve registers.
constexpr int64_t kPixels = 6;
/// Products that are added in one go: their weights, 16 KB, stay in the first cache.
constexpr int64_t kRun = 256;
/// Pixels that are worth a unit of work.
constexpr int64_t kUnitPixels = 64;

/// Weights by blocks of 16 channels of y: (block, tap row, tap and channel of x, channel).
std::vector<float> packed_weights(const Shape& shape, const float* weight) {
  const int64_t taps = shape.taps, in = shape.channels_in;
  std::vector<float> packed(shape.channels_out * taps * taps * in);
  for (int64_t out = 0; out < shape.channels_out; ++out)
    for (int64_t c = 0; c < in; ++c)
      for (int64_t tap = 0; tap < taps * taps; ++tap)
        packed[((out / kBlock * taps * taps + tap) * in + c) * kBlock + out % kBlock] =
            weight[(out * in + c) * taps * taps + tap];
  return packed;
}

/// Where pixels of x and y are, and how far apart.
struct Line {
  const float* x;
  float* y;
  int64_t x_step, y_step;
};

/// Adds `count` products to 16 channels of some pixels, or begins them with `first` (16 numbers or nullptr).
template <int64_t kCount>
void add_tile(const Line& line, const float* weights, int64_t count, bool begins, const float* first) {
  __m256 sum[kCount][2];
#pragma GCC unroll 6
  for (int64_t p = 0; p < kCount; ++p)
#pragma GCC unroll 2
    for (int64_t half = 0; half < 2; ++half)
      sum[p][half] = !begins ? _mm256_loadu_ps(line.y + p * line.y_step + 8 * half)
                     : first ? _mm256_loadu_ps(first + 8 * half)
                             : _mm256_setzero_ps();
  for (int64_t k = 0; k < count; ++k) {
    const __m256 low = _mm256_loadu_ps(weights + k * kBlock),
                 high = _mm256_loadu_ps(weights + k * kBlock + 8);
#pragma GCC unroll 6
    for (int64_t p = 0; p < kCount; ++p) {
      const __m256 value = _mm256_broadcast_ss(line.x + p * line.x_step + k);
      sum[p][0] = _mm256_fmadd_ps(value, low, sum[p][0]);
      sum[p][1] = _mm256_fmadd_ps(value, high, sum[p][1]);
    }
  }
#pragma GCC unroll 6
  for (int64_t p = 0; p < kCount; ++p)
#pragma GCC unroll 2
    for (int64_t half = 0; half < 2; ++half)
      _mm256_storeu_ps(line.y + p * line.y_step + 8 * half, sum[p][half]);
}

using AddTile = void (*)(const Line&, const float*, int64_t, bool, const float*);
template <int64_t... kCounts>
constexpr std::array<AddTile, kPixels> tiles(std::integer_sequence<int64_t, kCounts...>) {
  return {add_tile<kCounts + 1>...};
}

/// The same for a line of any number of pixels.
void add_line(Line line, int64_t pixels, const float* weights, int64_t count, bool begins,
              const float* first) {
  static constexpr std::array<AddTile, kPixels> kTiles =
      tiles(std::make_integer_sequence<int64_t, kPixels>());
  for (int64_t p = 0; p < pixels; p += kPixels) {
    kTiles[std::min(kPixels, pixels - p) - 1](line, weights, count, begins, first);
    line.x += kPixels * line.x_step;
    line.y += kPixels * line.y_step;
  }
}

/// Rows of x around rows [begin, end) of y, with zeros around the picture: the products of a tap row are then
/// side by side for each pixel.
std::vector<float> padded_rows(const Shape& shape, const float* image, int64_t begin, int64_t end) {
  const int64_t length = (shape.width + 2) * shape.channels_in, row = shape.width * shape.channels_in;
  const int64_t top = begin * shape.stride - 1, count = (end - begin - 1) * shape.stride + 3;
  std::vector<float> rows(count * length);
  for (int64_t r = 0; r < count; ++r)
    if (top + r >= 0 && top + r < shape.height)
      std::memcpy(&rows[r * length + shape.channels_in], image + (top + r) * row, row * sizeof(float));
  return rows;
}

struct Layer {
  const float *weights, *bias;  // packed_weights; of channels, or nullptr
};

/// Rows [begin, end) of y of one image.
void convolve_rows(const Shape& shape, const float* image, const Layer& layer, float* y, int64_t begin,
                   int64_t end) {
  const bool is_point = shape.taps == 1;
  const std::vector<float> rows = is_point ? std::vector<float>() : padded_rows(shape, image, begin, end);
  const float* x = is_point ? image + begin * shape.width * shape.channels_in : rows.data();
  const int64_t row_step = (shape.width + (is_point ? 0 : 2)) * shape.channels_in;
  const int64_t width = shape.width_out(), products = shape.taps * shape.channels_in;
  for (int64_t out = 0; out < shape.channels_out; out += kBlock)
    for (int64_t tap_row = 0; tap_row < shape.taps; ++tap_row)
      for (int64_t k = 0; k < products; k += kRun)
        for (int64_t r = begin; r < end; ++r)
          add_line({x + ((r - begin) * shape.stride + tap_row) * row_step + k,
                    y + r * width * shape.channels_out + out, shape.stride * shape.channels_in,
                    shape.channels_out},
                   width, layer.weights + ((out / kBlock * shape.taps + tap_row) * products + k) * kBlock,
                   std::min(kRun, products - k), tap_row == 0 && k == 0,
                   layer.bias ? layer.bias + out : nullptr);
}

}  // namespace

bool is_compiled() {
  return true;
}

bool pays() {
  return !__builtin_cpu_supports("avx512f");
}

void forward(const Shape& shape, const float* x, const float* weight, const float* bias, float* y,
             ParallelFor parallel_for) {
  const std::vector<float> weights = packed_weights(shape, weight);
  const int64_t height = shape.height_out(), width = shape.width_out();
  const int64_t rows = std::clamp((kUnitPixels + width - 1) / width, int64_t{1}, height);
  const int64_t units = (height + rows - 1) / rows;  // of an image
  for_each(shape.images * units, parallel_for, [&](int64_t unit) {
    const int64_t image = unit / units, begin = unit % units * rows;
    convolve_rows(shape, x + image * shape.height * shape.width * shape.channels_in, {weights.data(), bias},
                  y + image * height * width * shape.channels_out, begin, std::min(height, begin + rows));
  });
}

#else

bool is_compiled() {
  return false;
}

bool pays() {
  return false;
}

void forward(const Shape&, const float*, const float*, const float*, float*, ParallelFor) {
  throw std::logic_error("the kernel of convolutions is not in this build");
}

#endif

}  // namespace ohb::learner::conv_kernel
