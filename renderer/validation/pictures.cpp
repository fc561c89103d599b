#include "renderer/validation/pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/model/colour.h"

namespace ohb::validation {
namespace {

constexpr float kBackground = 0.93f;  // encoded grey
constexpr double kPercentile = 0.98;

float percentile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace

Image display_picture(const Image& rgb, const Image& coverage, float exposure) {
  Image picture(rgb.width_px, rgb.height_px, 3);
  const float background = srgb_to_linear(kBackground);
  for (size_t i = 0; i < picture.values.size(); ++i) {
    const float light = exposure * rgb.values[i] + (1 - coverage.values[i / 3]) * background;
    picture.values[i] = linear_to_srgb(std::clamp(light, 0.0f, 1.0f));
  }
  return picture;
}

float exposure_for(const Image& rgb, const Image& coverage) {
  std::vector<float> brightest;
  for (size_t i = 0; i < coverage.values.size(); ++i)
    if (coverage.values[i] > 0.5f)
      brightest.push_back(std::max({rgb.values[3 * i], rgb.values[3 * i + 1], rgb.values[3 * i + 2]}));
  const float high = percentile(brightest, kPercentile);
  return high > 0 ? 0.8f / high : 1;
}

Vec3f diverging_colour(float x) {
  static const std::array<Vec3f, 5> kStops = {Vec3f{33, 102, 172}, Vec3f{146, 197, 222}, Vec3f{247, 247, 247},
                                              Vec3f{244, 165, 130}, Vec3f{178, 24, 43}};
  const float place = 2 * (std::clamp(x, -1.0f, 1.0f) + 1);
  const int stop = std::min(static_cast<int>(place), 3);
  const float rest = place - static_cast<float>(stop);
  return ((1 - rest) * kStops[stop] + rest * kStops[stop + 1]) / 255.0f;
}

Image diverging_picture(const Image& values, const std::vector<uint8_t>& pixels, float limit) {
  Image picture(values.width_px, values.height_px, 3);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Vec3f colour =
        pixels[i] ? diverging_colour(values.values[i] / limit) : Vec3f{kBackground, kBackground, kBackground};
    for (int c = 0; c < 3; ++c) picture.values[3 * i + c] = colour[c];
  }
  return picture;
}

float round_limit(const Image& values, const std::vector<uint8_t>& pixels, float least) {
  std::vector<float> sizes;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i]) sizes.push_back(std::fabs(values.values[i]));
  const float high = std::max(percentile(sizes, kPercentile), least);
  const float power = std::pow(10.0f, std::floor(std::log10(high)));
  for (const float step : {1.0f, 2.0f, 5.0f})
    if (step * power >= high * 0.999f) return step * power;
  return 10 * power;
}

}  // namespace ohb::validation
