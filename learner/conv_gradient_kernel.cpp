#include "learner/conv_kernel.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <vector>

#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#define OHB_CONV_GRADIENT 1
#endif

namespace ohb::learner::conv_kernel {

#ifdef OHB_CONV_GRADIENT
namespace {

constexpr int64_t kTaps = 3;
/// Units of work that are wanted, whatever the threads, and rows that are worth one.
constexpr int64_t kUnits = 32, kLeastRows = 4;

/// The sums of one run of rows and one block of channels of x: (tap row, tap, channel of x, channel of y).
struct Sums {
  float* first;
  int64_t channels_out;
  float* at(int64_t row, int64_t tap, int64_t in, int64_t out) const {
    return first + ((row * kTaps + tap) * kBlock + in) * channels_out + out;
  }
};
int64_t sums_count(const Shape& shape) {
  return kTaps * kTaps * kBlock * shape.channels_out;
}

/// Sums of three taps, two channels of x and 16 of y: twelve registers, if every index is a constant, for
/// which loops over them are unrolled.
struct Registers {
  __m256 sum[kTaps][2][2];
};

template <typename Body>
[[gnu::always_inline]] inline void for_each_register(Body body) {
#pragma GCC unroll 3
  for (int64_t tap = 0; tap < kTaps; ++tap)
#pragma GCC unroll 2
    for (int64_t i = 0; i < 2; ++i)
#pragma GCC unroll 2
      for (int64_t half = 0; half < 2; ++half) body(tap, i, half);
}

/// Adds what a row of y, 16 channels, and a row of x, of which two channels count, give to three taps, whose
/// sums begin at `sums`.
template <int64_t kStride>
void add_row(const float* x, const float* y, int64_t width_out, float* sums, int64_t channels_out) {
  const auto place = [&](int64_t tap, int64_t i, int64_t half) {
    return sums + (tap * kBlock + i) * channels_out + 8 * half;
  };
  Registers r;
  for_each_register([&](int64_t tap, int64_t i, int64_t half) {
    r.sum[tap][i][half] = _mm256_loadu_ps(place(tap, i, half));
  });
  for (int64_t p = 0; p < width_out; ++p) {
    const __m256 of_y[2] = {_mm256_loadu_ps(y + p * kBlock), _mm256_loadu_ps(y + p * kBlock + 8)};
    const float* of_x = x + p * kStride * kBlock;
    for_each_register([&](int64_t tap, int64_t i, int64_t half) {
      r.sum[tap][i][half] =
          _mm256_fmadd_ps(_mm256_broadcast_ss(of_x + tap * kBlock + i), of_y[half], r.sum[tap][i][half]);
    });
  }
  for_each_register([&](int64_t tap, int64_t i, int64_t half) {
    _mm256_storeu_ps(place(tap, i, half), r.sum[tap][i][half]);
  });
}

/// One block of x's channels in three rows, with a zero before and behind each: row r is at r % 3.
class Rows {
 public:
  Rows(const Shape& shape, const float* x, int64_t first_channel)
      : shape_(shape), x_(x + first_channel), length_((shape.width + 2) * kBlock), values_(kTaps * length_) {}
  /// nullptr above and below the picture. What was given before stays valid for the two rows before it.
  const float* row(int64_t image, int64_t r) {
    if (r < 0 || r >= shape_.height) return nullptr;
    float* values = &values_[(r % kTaps) * length_];
    const int64_t number = image * shape_.height + r;
    if (held_[r % kTaps] == number) return values;
    held_[r % kTaps] = number;
    const float* from = x_ + number * shape_.width * shape_.channels_in;
    for (int64_t column = 0; column < shape_.width; ++column)
      std::memcpy(values + (column + 1) * kBlock, from + column * shape_.channels_in, kBlock * sizeof(float));
    return values;
  }

 private:
  const Shape& shape_;
  const float* x_;
  int64_t length_;
  std::vector<float> values_;
  std::array<int64_t, kTaps> held_ = {-1, -1, -1};
};

/// Rows [begin, end) of y, counted through all images.
void add_rows(const Shape& shape, const float* y_gradient, Rows& rows, int64_t begin, int64_t end,
              const Sums& sums) {
  const int64_t width = shape.width_out(), height = shape.height_out();
  const auto add = shape.stride == 1 ? add_row<1> : add_row<2>;
  std::vector<float> y(width * kBlock);
  for (int64_t r = begin; r < end; ++r) {
    std::array<const float*, kTaps> x;
    for (int64_t row = 0; row < kTaps; ++row)
      x[row] = rows.row(r / height, r % height * shape.stride + row - 1);
    for (int64_t out = 0; out < shape.channels_out; out += kBlock) {
      for (int64_t p = 0; p < width; ++p)
        std::memcpy(&y[p * kBlock], y_gradient + (r * width + p) * shape.channels_out + out,
                    kBlock * sizeof(float));
      for (int64_t row = 0; row < kTaps; ++row)
        for (int64_t in = 0; x[row] != nullptr && in < kBlock; in += 2)
          add(x[row] + in, y.data(), width, sums.at(row, 0, in, out), shape.channels_out);
    }
  }
}

}  // namespace

void weight_gradient(const Shape& shape, const float* x, const float* y_gradient, float* gradient,
                     ParallelFor parallel_for) {
  const int64_t blocks = shape.channels_in / kBlock, rows = shape.images * shape.height_out();
  const int64_t runs =
      std::clamp((kUnits + blocks - 1) / blocks, int64_t{1}, (rows + kLeastRows - 1) / kLeastRows);
  const int64_t count = sums_count(shape);
  std::vector<float> sums(runs * blocks * count);
  for_each(runs * blocks, parallel_for, [&](int64_t unit) {
    const int64_t run = unit / blocks, block = unit % blocks;
    Rows of_x(shape, x, block * kBlock);
    add_rows(shape, y_gradient, of_x, rows * run / runs, rows * (run + 1) / runs,
             {&sums[unit * count], shape.channels_out});
  });
  for_each(blocks, parallel_for, [&](int64_t block) {
    float* first = &sums[block * count];
    for (int64_t run = 1; run < runs; ++run)
      for (int64_t i = 0; i < count; ++i) first[i] += sums[(run * blocks + block) * count + i];
    const Sums all = {first, shape.channels_out};
    for (int64_t out = 0; out < shape.channels_out; ++out)
      for (int64_t in = 0; in < kBlock; ++in)
        for (int64_t tap = 0; tap < kTaps * kTaps; ++tap)
          gradient[(out * shape.channels_in + block * kBlock + in) * kTaps * kTaps + tap] =
              *all.at(tap / kTaps, tap % kTaps, in, out);
  });
}

#else

void weight_gradient(const Shape&, const float*, const float*, float*, ParallelFor) {
  throw std::logic_error("the kernel of the weights' gradient is not in this build");
}

#endif

}  // namespace ohb::learner::conv_kernel
