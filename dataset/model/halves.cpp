#include "dataset/model/halves.h"

#include <Imath/half.h>

#include <algorithm>

#include "dataset/model/parallel.h"
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace ohb {
namespace {

void convert(const float* values, size_t count, uint16_t* halves) {
  for (size_t i = 0; i < count; ++i)
    halves[i] = imath_float_to_half(std::clamp(values[i], -kLargestHalf, kLargestHalf));
}

void expand(const uint16_t* halves, size_t count, float* values) {
  for (size_t i = 0; i < count; ++i) values[i] = imath_half_to_float(halves[i]);
}

#if defined(__x86_64__)
/// The same; a tenth of the time.
__attribute__((target("avx,f16c"))) void convert_by_eight(const float* values, size_t count,
                                                          uint16_t* halves) {
  const __m256 least = _mm256_set1_ps(-kLargestHalf), most = _mm256_set1_ps(kLargestHalf);
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    // Where one of two operands is NaN both take the second.
    const __m256 clamped = _mm256_min_ps(most, _mm256_max_ps(least, _mm256_loadu_ps(values + i)));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(halves + i),
                     _mm256_cvtps_ph(clamped, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
  }
  convert(values + i, count - i, halves + i);
}

__attribute__((target("avx,f16c"))) void expand_by_eight(const uint16_t* halves, size_t count,
                                                         float* values) {
  size_t i = 0;
  for (; i + 8 <= count; i += 8)
    _mm256_storeu_ps(values + i,
                     _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(halves + i))));
  expand(halves + i, count - i, values + i);
}

bool has_f16c() {
#if defined(__clang__)
  return __builtin_cpu_supports("avx2");  // clang 14 has no word for F16C, which each such processor has
#else
  return __builtin_cpu_supports("f16c");
#endif
}
#endif

}  // namespace

std::vector<uint16_t> halves_of(const float* values, size_t count) {
  std::vector<uint16_t> halves(count);
#if defined(__x86_64__)
  const auto run = has_f16c() ? convert_by_eight : convert;
#else
  const auto run = convert;
#endif
  constexpr size_t kAtOnce = 1 << 16;
  parallel_for_each(0, static_cast<int>((count + kAtOnce - 1) / kAtOnce), [&](int block) {
    const size_t first = kAtOnce * static_cast<size_t>(block);
    run(values + first, std::min(kAtOnce, count - first), halves.data() + first);
  });
  return halves;
}

void floats_of(const uint16_t* halves, size_t count, float* values) {
#if defined(__x86_64__)
  if (has_f16c()) return expand_by_eight(halves, count, values);
#endif
  expand(halves, count, values);
}

}  // namespace ohb
