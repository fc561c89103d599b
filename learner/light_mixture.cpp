#include "learner/light_mixture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "learner/hash.h"

namespace ohb::learner {
namespace {

constexpr double kMixed = 0.5, kTintStops = 0.5;

double foreground_mean(const Image& radiance, const Image& mask) {
  double sum = 0, pixels = 0;
  for (size_t p = 0; p < mask.values.size(); ++p)
    if (mask.values[p] > 0.5f) {
      for (int c = 0; c < 3; ++c) sum += radiance.values[3 * p + c];
      pixels += 3;
    }
  return pixels > 0 ? sum / pixels : 0;
}

}  // namespace

SampleLight mixed_light(const Sample& sample, uint64_t key) {
  uint64_t drawn = 0;
  const auto uniform = [&] { return uniform_of(key, drawn++); };
  const auto any = [&]() -> const SampleLight& {
    return sample
        .lights[std::min(sample.lights.size() - 1,
                         static_cast<size_t>(uniform() * static_cast<double>(sample.lights.size())))];
  };
  const SampleLight& first = any();
  if (uniform() >= kMixed) return first;
  const SampleLight& second = any();
  const double share = uniform();
  std::array<std::array<float, 3>, 2> gains{};
  for (const auto& [light, part, gain] :
       {std::tuple{&first, share, &gains[0]}, std::tuple{&second, 1 - share, &gains[1]}}) {
    const double mean = foreground_mean(light->radiance, sample.mask);
    for (float& g : *gain)
      g = mean > 0 ? static_cast<float>(part / mean * std::exp2(kTintStops * (2 * uniform() - 1))) : 0.0f;
  }
  SampleLight mixed = first;
  mixed.name = first.name + " and " + second.name;
  for (size_t i = 0; i < mixed.radiance.values.size(); ++i)
    mixed.radiance.values[i] =
        gains[0][i % 3] * first.radiance.values[i] + gains[1][i % 3] * second.radiance.values[i];
  return mixed;
}

}  // namespace ohb::learner
