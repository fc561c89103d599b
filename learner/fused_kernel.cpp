#include "learner/fused_kernel.h"

#include <algorithm>
#include <cstring>

#include "dataset/model/colour.h"

namespace ohb::learner::shading {
namespace {

constexpr double kMinLength = 1e-4;

// Natural logarithm of a positive normal x to 1e-7, in operations that vectorise (cephes' polynomial).
[[gnu::always_inline]] inline float log_of(float x) {
  int32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  // Mantissa into [sqrt(1/2), sqrt(2)).
  const int32_t offset = bits - 0x3f3504f3;
  const float exponent = static_cast<float>(offset >> 23);
  const int32_t mantissa_bits = (offset & 0x007fffff) + 0x3f3504f3;
  float m;
  std::memcpy(&m, &mantissa_bits, sizeof m);
  m -= 1.0f;
  float p = 7.0376836292e-2f;
  p = p * m - 1.1514610310e-1f;
  p = p * m + 1.1676998740e-1f;
  p = p * m - 1.2420140846e-1f;
  p = p * m + 1.4249322787e-1f;
  p = p * m - 1.6668057665e-1f;
  p = p * m + 2.0000714765e-1f;
  p = p * m - 2.4999993993e-1f;
  p = p * m + 3.3333331174e-1f;
  const float m2 = m * m;
  return (p * m * m2 - 0.5f * m2 + m) + exponent * 0.693147180559945f;
}
inline double log_of(double x) {
  return std::log(x);
}

/// Structure of arrays, so that the loop over pixels runs in vector registers.
template <typename T>
struct Block {
  T u[kBlock], v[kBlock], z[kBlock], nx[kBlock], ny[kBlock], nz[kBlock], d0[kBlock], d1[kBlock], d2[kBlock],
      roughness[kBlock], f0[kBlock], sss[kBlock];

  [[gnu::always_inline]] Surface<T> surface(int i) const {
    return {u[i], v[i], z[i], nx[i], ny[i], nz[i], d0[i], d1[i], d2[i], roughness[i], f0[i], sss[i]};
  }
};

template <typename T>
struct BlockSums {
  T loss[kBlock], nx[kBlock], ny[kBlock], nz[kBlock], z[kBlock], d0[kBlock], d1[kBlock], d2[kBlock],
      roughness[kBlock], f0[kBlock], sss[kBlock];
};

/// What loading forgets and the gradient needs again.
struct LoadedPixel {
  double inv_length, f0_slope;
  bool roughness_raised;
};

template <typename T>
void load(Block<T>& block, LoadedPixel* loaded, const Job<T>& job, const Planes<const T*>& planes,
          const int32_t* pixels, int count) {
  const size_t plane = static_cast<size_t>(job.width_px) * job.height_px;
  const T half_px = T(2) / static_cast<T>(job.width_px);
  for (int i = 0; i < kBlock; ++i) {
    const size_t p = static_cast<size_t>(pixels[i < count ? i : 0]);  // the rest repeats pixel 0, unused
    block.u[i] = (static_cast<T>(p % job.width_px) + T(0.5)) * half_px - T(1);
    block.v[i] =
        (T(0.5) * static_cast<T>(job.height_px) - static_cast<T>(p / job.width_px) - T(0.5)) * half_px;
    block.z[i] = planes[kDisplacement][p];
    const double x = planes[kNormal][p], y = planes[kNormal][p + plane], z = planes[kNormal][p + 2 * plane];
    const double length = std::sqrt(x * x + y * y + z * z);
    const bool degenerate = length < kMinLength;
    loaded[i].inv_length = degenerate ? 0 : 1 / length;
    block.nx[i] = static_cast<T>(degenerate ? 0 : x / length);
    block.ny[i] = static_cast<T>(degenerate ? 0 : y / length);
    block.nz[i] = static_cast<T>(degenerate ? 1 : z / length);
    block.d0[i] = planes[kDiffuse][p];
    block.d1[i] = planes[kDiffuse][p + plane];
    block.d2[i] = planes[kDiffuse][p + 2 * plane];
    loaded[i].roughness_raised = planes[kRoughness][p] < job.options.min_roughness;
    block.roughness[i] =
        loaded[i].roughness_raised ? static_cast<T>(job.options.min_roughness) : planes[kRoughness][p];
    const F0 f0 = f0_of(planes[kSpecular][p], job.options.specular);
    block.f0[i] = static_cast<T>(f0.value);
    loaded[i].f0_slope = f0.slope;
    block.sss[i] = planes[kSss][p];
  }
}

/// d|p - t|/dp, or that of |ln(1 + p) - ln(1 + t)|; adds the loss. Equal maps give equal bits of p and t (the
/// compiler may not contract products and sums, see CMakeLists.txt), and so no gradient.
template <bool kLog, typename T>
[[gnu::always_inline]] inline T difference(T prediction, T truth, T& loss) {
  const T d = prediction - truth;
  const T sign = d > T(0) ? T(1) : d < T(0) ? T(-1) : T(0);
  if constexpr (kLog) {
    const T one_over = T(1) / (T(1) + prediction);
    const T ratio = T(1) - d * one_over;  // (1 + t) / (1 + p), and exactly 1 where they are equal
    const T logarithm = log_of(ratio);
    // The last term is 0, or NaN where log_of would hide it.
    loss += (logarithm < T(0) ? -logarithm : logarithm) + (ratio - ratio);
    return sign * one_over;
  } else {
    loss += d < T(0) ? -d : d;
    return sign;
  }
}

template <bool kLog, typename T>
void add_light(BlockSums<T>& sums, const Block<T>& prediction, const Block<T>& truth, const Light<T>& light) {
#pragma GCC ivdep
  for (int i = 0; i < kBlock; ++i) {
    const Surface<T> surface = prediction.surface(i);
    const Reflection<T> mine = reflect(surface, light);
    const Reflection<T> wanted = reflect(truth.surface(i), light);
    T loss = 0;
    const T g0 = difference<kLog>(mine.out0, wanted.out0, loss);
    const T g1 = difference<kLog>(mine.out1, wanted.out1, loss);
    const T g2 = difference<kLog>(mine.out2, wanted.out2, loss);
    const SurfaceGradient<T> g = reflect_backward(surface, mine, g0, g1, g2);
    sums.loss[i] += loss;
    sums.nx[i] += g.nx;
    sums.ny[i] += g.ny;
    sums.nz[i] += g.nz;
    sums.z[i] += g.z;
    sums.d0[i] += g.d0;
    sums.d1[i] += g.d1;
    sums.d2[i] += g.d2;
    sums.roughness[i] += g.roughness;
    sums.f0[i] += g.f0;
    sums.sss[i] += g.sss;
  }
}

template <typename T>
void store(const Job<T>& job, const Block<T>& block, const LoadedPixel* loaded, const BlockSums<T>& sums,
           const int32_t* pixels, int count) {
  const size_t plane = static_cast<size_t>(job.width_px) * job.height_px;
  const Planes<T*>& out = job.gradient;
  for (int i = 0; i < count; ++i) {
    const size_t p = static_cast<size_t>(pixels[i]);
    if (out[kNormal]) {
      const double nx = block.nx[i], ny = block.ny[i], nz = block.nz[i];
      const double radial = sums.nx[i] * nx + sums.ny[i] * ny + sums.nz[i] * nz;
      const double scale = job.scale * loaded[i].inv_length;
      out[kNormal][p] = static_cast<T>(scale * (sums.nx[i] - radial * nx));
      out[kNormal][p + plane] = static_cast<T>(scale * (sums.ny[i] - radial * ny));
      out[kNormal][p + 2 * plane] = static_cast<T>(scale * (sums.nz[i] - radial * nz));
    }
    if (out[kDiffuse]) {
      out[kDiffuse][p] = static_cast<T>(job.scale * sums.d0[i]);
      out[kDiffuse][p + plane] = static_cast<T>(job.scale * sums.d1[i]);
      out[kDiffuse][p + 2 * plane] = static_cast<T>(job.scale * sums.d2[i]);
    }
    if (out[kRoughness])
      out[kRoughness][p] = loaded[i].roughness_raised ? T(0) : static_cast<T>(job.scale * sums.roughness[i]);
    if (out[kSpecular]) out[kSpecular][p] = static_cast<T>(job.scale * loaded[i].f0_slope * sums.f0[i]);
    if (out[kSss]) out[kSss][p] = static_cast<T>(job.scale * sums.sss[i]);
    if (out[kDisplacement]) out[kDisplacement][p] = static_cast<T>(job.scale * sums.z[i]);
  }
}

/// The loss of `count` <= kBlock pixels.
template <typename T>
double loss_of_block(const Job<T>& job, const int32_t* pixels, int count) {
  Block<T> truth, prediction;
  LoadedPixel of_truth[kBlock], of_prediction[kBlock];
  load(truth, of_truth, job, job.truth, pixels, count);
  load(prediction, of_prediction, job, job.prediction, pixels, count);
  BlockSums<T> sums{};
  for (const Light<T>& light : job.lights)
    if (job.options.log_domain)
      add_light<true>(sums, prediction, truth, light);
    else
      add_light<false>(sums, prediction, truth, light);
  store(job, prediction, of_prediction, sums, pixels, count);
  double loss = 0;
  for (int i = 0; i < count; ++i) loss += sums.loss[i];
  return loss;
}

}  // namespace

F0 f0_of(double s, SpecularEncoding encoding) {
  const double clamped = s < 0 ? 0 : s > 1 ? 1 : s;
  const double inside = s < 0 || s > 1 ? 0 : 1;
  switch (encoding) {
    case SpecularEncoding::kDisney08:
      return {0.08 * clamped, 0.08 * inside};
    case SpecularEncoding::kLinearF0:
      return {clamped, inside};
    case SpecularEncoding::kSrgbF0:
      break;
  }
  if (clamped <= 0.04045) return {clamped / 12.92, inside / 12.92};
  const double base = (clamped + 0.055) / 1.055, power = std::pow(base, 1.4);
  return {power * base, inside * 2.4 / 1.055 * power};
}

template <typename T>
double loss_of_pixels(const Job<T>& job, const std::vector<int32_t>& pixels, int threads) {
  const int64_t count = static_cast<int64_t>(pixels.size()), blocks = (count + kBlock - 1) / kBlock;
  std::vector<double> losses(static_cast<size_t>(blocks));
#pragma omp parallel for num_threads(threads) schedule(dynamic, 4)
  for (int64_t b = 0; b < blocks; ++b) {
    const int64_t first = b * kBlock;
    losses[static_cast<size_t>(b)] =
        loss_of_block(job, pixels.data() + first, static_cast<int>(std::min<int64_t>(kBlock, count - first)));
  }
  double sum = 0;  // in the order of the blocks, whatever thread ran them
  for (const double loss : losses) sum += loss;
  return sum * job.scale;
}

template double loss_of_pixels<float>(const Job<float>&, const std::vector<int32_t>&, int);
template double loss_of_pixels<double>(const Job<double>&, const std::vector<int32_t>&, int);

}  // namespace ohb::learner::shading
