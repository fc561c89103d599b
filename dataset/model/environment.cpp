#include "dataset/model/environment.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "dataset/model/image_place.h"

namespace ohb {
namespace {

constexpr float kPi = 3.14159265358979323846f;

// Resampling filters undershoot beside bright spots; Blender's own maps have up to 3e-7 of their light so.
constexpr double kLargestUndershoot = 1e-4;

[[noreturn]] void throw_bad_texel(const Image& image, const std::string& file, size_t first, size_t count,
                                  const std::string& what) {
  const size_t texel = first / image.channels;
  throw InputError(
      file,
      "texel (" + std::to_string(texel % image.width_px) + ", " + std::to_string(texel / image.width_px) +
          ")",
      "is " + what + " (" + std::to_string(count) + " such values)",
      "repair the picture: replace them by their neighbours, cut infinite suns to a finite value");
}

/// Index of the first value that is bad, and how many are.
template <class Bad>
std::pair<size_t, size_t> count_if_bad(const std::vector<float>& values, const Bad& bad) {
  size_t first = 0, count = 0;
  for (size_t i = 0; i < values.size(); ++i)
    if (bad(values[i]) && count++ == 0) first = i;
  return {first, count};
}

/// Refuses what is no radiance; sets slight undershoot to 0 and returns how many values that were.
size_t mend_texels(Image& image, const std::string& file) {
  const auto [not_finite, not_finite_count] =
      count_if_bad(image.values, [](float v) { return !std::isfinite(v); });
  if (not_finite_count > 0) throw_bad_texel(image, file, not_finite, not_finite_count, "NaN or infinite");
  double positive = 0, negative = 0;
  for (const float value : image.values) (value > 0 ? positive : negative) += std::fabs(value);
  if (positive == 0)
    throw InputError(file, "", "is all black: nothing would be lit", "use another environment");
  const auto [below_zero, below_zero_count] = count_if_bad(image.values, [](float v) { return v < 0; });
  if (negative > kLargestUndershoot * positive)
    throw_bad_texel(image, file, below_zero, below_zero_count, "negative");
  for (float& value : image.values) value = std::max(value, 0.0f);
  return below_zero_count;
}

/// An integer picture ends at 1, where a sky goes on to 10 and a sun to 100,000. PNG says where its values
/// are linear (a gAMA of 1, as oiiotool writes them from an EXR); everything else is sRGB.
void decode_integers(Environment& environment, const ImageFileInfo& info) {
  if (!info.says_linear)
    for (float& value : environment.radiance.values) value = srgb_to_linear(value);
  environment.warnings.push_back(
      "holds " + std::to_string(info.bits) + "-bit values, " +
      (info.says_linear ? "linear as it says itself" : "decoded from sRGB") +
      ": nothing in it is brighter than white, so there is no sun and shadows are weak; use an .exr or .hdr "
      "panorama");
}

}  // namespace

Environment read_environment(const std::filesystem::path& file) {
  ImageFileInfo info;
  Image image = read_image(file, &info);
  image = upright(image, info.orientation);
  const std::string name = file.string();
  if (image.width_px != 2 * image.height_px)
    throw InputError(name, "",
                     std::to_string(image.width_px) + " x " + std::to_string(image.height_px) +
                         " is not a latitude-longitude map of 2:1",
                     "convert it to latitude-longitude");
  Environment environment;
  environment.name = file.stem().string();
  environment.file = std::filesystem::absolute(file);
  environment.sha256 = sha256_of_file(file);
  environment.radiance = Image(image.width_px, image.height_px, 3);
  const size_t texels = static_cast<size_t>(image.width_px) * image.height_px;
  for (size_t i = 0; i < texels; ++i)
    for (int c = 0; c < 3; ++c)
      environment.radiance.values[3 * i + c] =
          image.values[i * image.channels + (image.channels >= 3 ? c : 0)];
  if (!info.is_float) decode_integers(environment, info);
  environment.mended_values = mend_texels(environment.radiance, name);
  for (const std::string& warning : environment.warnings) spdlog::warn("{}: {}", name, warning);
  return environment;
}

Vec2f environment_uv(Vec3f d) {
  return {0.5f + std::atan2(d.z, d.x) / (2 * kPi), std::acos(std::clamp(d.y, -1.0f, 1.0f)) / kPi};
}

Vec3f environment_direction(Vec2f uv) {
  const float phi = (uv.x - 0.5f) * 2 * kPi, theta = uv.y * kPi;
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

Vec3f brightest_direction(const Environment& environment) {
  const Image& image = environment.radiance;
  size_t best = 0;
  float best_value = -1;
  for (size_t i = 0; i < image.values.size() / 3; ++i) {
    const float value = image.values[3 * i] + image.values[3 * i + 1] + image.values[3 * i + 2];
    if (value > best_value) best = i, best_value = value;
  }
  return environment_direction({(static_cast<float>(best % image.width_px) + 0.5f) / image.width_px,
                                (static_cast<float>(best / image.width_px) + 0.5f) / image.height_px});
}

}  // namespace ohb
