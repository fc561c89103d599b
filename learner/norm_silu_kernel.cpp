#include "learner/norm_silu_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <vector>

namespace ohb::learner::norm_silu_kernel {
namespace {

/// Pixels that are summed in one go: few enough for the cache and for sums in single precision.
constexpr int64_t kRun = 256;
/// Channels whose sums are held at once: two registers of AVX2.
constexpr int64_t kLanes = 16;

/// e^x to 2e-7 in plain arithmetic, which compilers turn into vector registers. NaN gives any number: what
/// is returned is multiplied by the argument, which keeps it NaN.
[[gnu::always_inline]] inline float exponential(float x) {
  // Far enough for a sigmoid in single precision. At 87 compilers multiply by the sigmoid of the limit,
  // 1e-38, in lanes that they then throw away: numbers too small for a normal float, at six times the cost.
  x = x > -50.0f ? x : -50.0f;
  x = x < 50.0f ? x : 50.0f;
  const float power = std::floor(x * 1.44269504f + 0.5f);
  const float r = (x - power * 0.693359375f) + power * 2.12194440e-4f;  // x - power ln 2, ln 2 in two parts
  float sum = 1.0f / 5040;
  sum = sum * r + 1.0f / 720;
  sum = sum * r + 1.0f / 120;
  sum = sum * r + 1.0f / 24;
  sum = sum * r + 1.0f / 6;
  sum = sum * r + 0.5f;
  sum = sum * r + 1;
  sum = sum * r + 1;
  const int32_t bits = (static_cast<int32_t>(power) + 127) << 23;
  float scale;
  std::memcpy(&scale, &bits, sizeof scale);
  return sum * scale;
}

[[gnu::always_inline]] inline float sigmoid(float z) {
  return 1.0f / (1.0f + exponential(-z));
}

/// Runs of pixels of all images.
struct Runs {
  explicit Runs(const Shape& shape) : shape(shape), a_image((shape.pixels + kRun - 1) / kRun) {}
  int64_t count() const { return shape.images * a_image; }
  int64_t image(int64_t run) const { return run / a_image; }
  int64_t first(int64_t run) const { return (run % a_image) * kRun; }
  int64_t pixels(int64_t run) const { return std::min(kRun, shape.pixels - first(run)); }
  /// Where the run begins in a (B, H, W, C) array.
  int64_t offset(int64_t run) const { return (image(run) * shape.pixels + first(run)) * shape.channels; }
  const Shape& shape;
  int64_t a_image;
};

/// Means and squared deviations from them, of `width` neighbouring channels in one run. Sums of a constant
/// number of channels stay in registers.
template <typename Width>
[[gnu::always_inline]] inline void moments_of_channels(const float* x, int64_t pixels, int64_t channels,
                                                       Width width, float* mean, float* squares) {
  float sum[kLanes] = {}, square[kLanes] = {}, middle[kLanes] = {};
  for (int64_t p = 0; p < pixels; ++p)
    for (int64_t c = 0; c < width; ++c) sum[c] += x[p * channels + c];
  for (int64_t c = 0; c < width; ++c) middle[c] = sum[c] / static_cast<float>(pixels);
  for (int64_t p = 0; p < pixels; ++p)
    for (int64_t c = 0; c < width; ++c) {
      const float d = x[p * channels + c] - middle[c];
      square[c] += d * d;
    }
  for (int64_t c = 0; c < width; ++c) {
    mean[c] = middle[c];
    squares[c] = square[c];
  }
}

void moments_of_run(const float* x, int64_t pixels, int64_t channels, float* mean, float* squares) {
  int64_t c = 0;
  for (; c + kLanes <= channels; c += kLanes)
    moments_of_channels(x + c, pixels, channels, std::integral_constant<int64_t, kLanes>(), mean + c,
                        squares + c);
  if (c < channels) moments_of_channels(x + c, pixels, channels, channels - c, mean + c, squares + c);
}

/// Moments of an image's groups from those of its runs and channels (Chan, Golub and LeVeque 1983).
void join_moments(const Runs& runs, const std::vector<float>& means, const std::vector<float>& squares,
                  const Forward& f) {
  const Shape& shape = runs.shape;
  const int64_t each = shape.channels / shape.groups;
  for (int64_t i = 0; i < shape.images * shape.groups; ++i) {
    const int64_t image = i / shape.groups, first = (i % shape.groups) * each;
    double count = 0, middle = 0, sum = 0;
    for (int64_t run = image * runs.a_image; run < (image + 1) * runs.a_image; ++run)
      for (int64_t c = first; c < first + each; ++c) {
        const double n = static_cast<double>(runs.pixels(run));
        const double step = means[run * shape.channels + c] - middle;
        sum += squares[run * shape.channels + c] + step * step * n * count / (n + count);
        count += n;
        middle += step * n / count;
      }
    f.mean[i] = static_cast<float>(middle);
    f.inverse_deviation[i] = static_cast<float>(1 / std::sqrt(sum / count + f.epsilon));
  }
}

/// z = x * scale + shift of one image's channels.
struct Line {
  Line(const Shape& shape, int64_t image, const float* gain, const float* offset, const float* mean,
       const float* inverse_deviation)
      : scale(shape.channels), shift(shape.channels) {
    const int64_t each = shape.channels / shape.groups;
    for (int64_t c = 0; c < shape.channels; ++c) {
      const int64_t group = image * shape.groups + c / each;
      scale[c] = gain[c] * inverse_deviation[group];
      shift[c] = offset[c] - mean[group] * scale[c];
    }
  }
  std::vector<float> scale, shift;
};

/// One run of the backward pass: the gradient of z goes to `out`, its sums and those of it times
/// z-before-gain to `sums` and `products`.
struct Slopes {
  const float *scale, *shift, *norm_scale, *norm_shift;
  float *sums, *products;
};
void slopes_of_run(const float* __restrict x, const float* __restrict y_gradient, int64_t pixels,
                   int64_t channels, const Slopes& s, float* __restrict out) {
  float* __restrict sums = s.sums, * __restrict products = s.products;
  std::fill(sums, sums + channels, 0.0f);
  std::fill(products, products + channels, 0.0f);
  for (int64_t p = 0; p < pixels; ++p, x += channels, y_gradient += channels, out += channels)
    for (int64_t c = 0; c < channels; ++c) {
      const float z = x[c] * s.scale[c] + s.shift[c], level = sigmoid(z);
      const float slope = y_gradient[c] * level * (1 + z * (1 - level));
      out[c] = slope;
      sums[c] += slope;
      products[c] += slope * (x[c] * s.norm_scale[c] + s.norm_shift[c]);
    }
}

/// What mean and deviation take from the gradient: with n the normalised x and dz the gradient of z, it is
/// (gain dz - mean(gain dz) - n mean(gain dz n)) / deviation, here as gain dz / deviation + x slope +
/// constant in one image's channels.
struct Centring {
  Centring(const Shape& shape, const Backward& b, int64_t image, const std::vector<double>& sum,
           const std::vector<double>& product)
      : slope(shape.channels), constant(shape.channels) {
    const int64_t each = shape.channels / shape.groups;
    for (int64_t first = 0; first < shape.channels; first += each) {
      const int64_t group = image * shape.groups + first / each;
      const double inverse = b.inverse_deviation[group];
      double level = 0, tilt = 0;
      for (int64_t c = first; c < first + each; ++c) {
        level += b.gain[c] * sum[c];
        tilt += b.gain[c] * product[c];
      }
      level /= static_cast<double>(each * shape.pixels);
      tilt /= static_cast<double>(each * shape.pixels);
      for (int64_t c = first; c < first + each; ++c) {
        slope[c] = static_cast<float>(-inverse * inverse * tilt);
        constant[c] = static_cast<float>(inverse * (inverse * b.mean[group] * tilt - level));
      }
    }
  }
  std::vector<float> slope, constant;
};

void centre_run(const float* __restrict x, int64_t pixels, const std::vector<float>& gain,
                const Centring& centring, float* __restrict out) {
  const int64_t channels = static_cast<int64_t>(gain.size());
  const float *scale = gain.data(), *slope = centring.slope.data(), *constant = centring.constant.data();
  for (int64_t p = 0; p < pixels; ++p, x += channels, out += channels)
    for (int64_t c = 0; c < channels; ++c) out[c] = out[c] * scale[c] + x[c] * slope[c] + constant[c];
}

/// y = SiLU(z) of one run.
void silu_of_run(const float* __restrict x, int64_t pixels, const Line& line, float* __restrict y) {
  const int64_t channels = static_cast<int64_t>(line.scale.size());
  const float *scale = line.scale.data(), *shift = line.shift.data();
  for (int64_t p = 0; p < pixels; ++p, x += channels, y += channels)
    for (int64_t c = 0; c < channels; ++c) {
      const float z = x[c] * scale[c] + shift[c];
      y[c] = z * sigmoid(z);
    }
}

}  // namespace

void forward(const Shape& shape, const Forward& f, ParallelFor parallel_for) {
  const Runs runs(shape);
  const int64_t channels = shape.channels;
  std::vector<float> means(runs.count() * channels), squares(runs.count() * channels);
  for_each(runs.count(), parallel_for, [&](int64_t run) {
    moments_of_run(f.x + runs.offset(run), runs.pixels(run), channels, &means[run * channels],
                   &squares[run * channels]);
  });
  join_moments(runs, means, squares, f);
  std::vector<Line> lines;
  for (int64_t i = 0; i < shape.images; ++i)
    lines.emplace_back(shape, i, f.gain, f.offset, f.mean, f.inverse_deviation);
  for_each(runs.count(), parallel_for, [&](int64_t run) {
    silu_of_run(f.x + runs.offset(run), runs.pixels(run), lines[runs.image(run)], f.y + runs.offset(run));
  });
}

void backward(const Shape& shape, const Backward& b, ParallelFor parallel_for) {
  const Runs runs(shape);
  const int64_t channels = shape.channels;
  const std::vector<float> ones(channels, 1.0f), zeros(channels, 0.0f);
  std::vector<Line> lines, norms;  // of z, and of the normalised x
  for (int64_t i = 0; i < shape.images; ++i) {
    lines.emplace_back(shape, i, b.gain, b.offset, b.mean, b.inverse_deviation);
    norms.emplace_back(shape, i, ones.data(), zeros.data(), b.mean, b.inverse_deviation);
  }
  std::vector<float> sums(runs.count() * channels), products(runs.count() * channels);
  for_each(runs.count(), parallel_for, [&](int64_t run) {
    const Line &line = lines[runs.image(run)], &norm = norms[runs.image(run)];
    slopes_of_run(b.x + runs.offset(run), b.y_gradient + runs.offset(run), runs.pixels(run), channels,
                  {line.scale.data(), line.shift.data(), norm.scale.data(), norm.shift.data(),
                   &sums[run * channels], &products[run * channels]},
                  b.x_gradient + runs.offset(run));
  });
  std::vector<Centring> centrings;
  std::vector<double> gain_gradient(channels), offset_gradient(channels);
  for (int64_t image = 0; image < shape.images; ++image) {
    std::vector<double> sum(channels), product(channels);
    for (int64_t run = image * runs.a_image; run < (image + 1) * runs.a_image; ++run)
      for (int64_t c = 0; c < channels; ++c) {
        sum[c] += sums[run * channels + c];
        product[c] += products[run * channels + c];
      }
    for (int64_t c = 0; c < channels; ++c) {
      offset_gradient[c] += sum[c];
      gain_gradient[c] += product[c];
    }
    centrings.emplace_back(shape, b, image, sum, product);
  }
  for_each(runs.count(), parallel_for, [&](int64_t run) {
    const Centring& centring = centrings[runs.image(run)];
    centre_run(b.x + runs.offset(run), runs.pixels(run), lines[runs.image(run)].scale, centring,
               b.x_gradient + runs.offset(run));
  });
  std::copy(gain_gradient.begin(), gain_gradient.end(), b.gain_gradient);
  std::copy(offset_gradient.begin(), offset_gradient.end(), b.offset_gradient);
}

}  // namespace ohb::learner::norm_silu_kernel
