#include "dataset/environments/panorama.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dataset/environments/primaries.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "dataset/model/halves.h"
#include "dataset/model/image_place.h"

namespace ohb::environments {
namespace {

constexpr double kMostMended = 0.01;  // of the texels, and of the light

/// What a picture of that shape usually is, and how to go on.
InputError shape_error(const std::string& file, int width_px, int height_px) {
  const double ratio = static_cast<double>(width_px) / height_px;
  const auto is_near = [&](double other) { return std::fabs(ratio / other - 1) < 0.02; };
  std::string cause =
      std::to_string(width_px) + " x " + std::to_string(height_px) + " is no latitude-longitude map of 2:1";
  std::string mend = "convert it to latitude-longitude";
  if (is_near(0.5))
    cause += ": it looks like one that lies on its side", mend = "turn it by 90 degrees";
  else if (is_near(1))
    cause += ": a mirror ball, an angular map, or two panoramas for two eyes",
        mend = "convert it to latitude-longitude, or cut one eye's half out";
  else if (is_near(4.0 / 3) || is_near(0.75) || is_near(6) || is_near(1.0 / 6) || is_near(1.5))
    cause += ": it looks like the six faces of a cube";
  return {file, "", cause, mend};
}

/// Grey ones light grey; alpha is not used.
Image three_channels(const Image& image) {
  if (image.channels == 3) return image;
  Image result(image.width_px, image.height_px, 3);
  const auto channels = static_cast<size_t>(image.channels);
  for (size_t i = 0; i < result.values.size() / 3; ++i)
    for (size_t c = 0; c < 3; ++c)
      result.values[3 * i + c] = image.values[i * channels + (channels >= 3 ? c : 0)];
  return result;
}

bool is_finite(const float* rgb) {
  return std::isfinite(rgb[0]) && std::isfinite(rgb[1]) && std::isfinite(rgb[2]);
}

/// The mean of the finite texels around one, from `image` as it was; 0 where there is none.
void mean_of_neighbours(const Image& image, int x, int y, float* mean) {
  double sum[3] = {};
  int count = 0;
  for (int v = std::max(0, y - 1); v <= std::min(y + 1, image.height_px - 1); ++v)
    for (int u = x - 1; u <= x + 1; ++u) {
      const float* from = image.pixel((u + image.width_px) % image.width_px, v);
      if (!is_finite(from)) continue;
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(from[c]);
      ++count;
    }
  for (int c = 0; c < 3; ++c) mean[c] = count == 0 ? 0 : static_cast<float>(sum[c] / count);
}

bool is_sun(const float* rgb) {
  const auto is_known = [](float v) {
    return std::isfinite(v) || v == std::numeric_limits<float>::infinity();
  };
  return is_known(rgb[0]) && is_known(rgb[1]) && is_known(rgb[2]);
}

void warn_of_mended(float brightest, Panorama& panorama) {
  if (panorama.nan > 0)
    panorama.warnings.push_back(std::to_string(panorama.nan) +
                                " texels were NaN and are now the mean of their neighbours");
  if (panorama.infinite > 0)
    panorama.warnings.push_back(std::to_string(panorama.infinite) + " texels were infinite and are now " +
                                std::to_string(static_cast<long long>(brightest)) +
                                ": the true sun was brighter");
}

void mend_what_is_not_finite(const std::string& file, Panorama& panorama) {
  Image& image = panorama.radiance;
  float brightest = kLargestHalf;  // an infinite half is at least as bright
  size_t bad = 0, first = 0;
  for (size_t i = 0; i < image.values.size(); i += 3) {
    for (size_t c = 0; c < 3; ++c)
      if (std::isfinite(image.values[i + c])) brightest = std::max(brightest, image.values[i + c]);
    if (!is_finite(&image.values[i]) && bad++ == 0) first = i / 3;
  }
  if (bad == 0) return;
  const auto width = static_cast<size_t>(image.width_px);
  if (static_cast<double>(bad) > kMostMended * static_cast<double>(image.values.size() / 3))
    throw InputError(file,
                     "texel (" + std::to_string(first % width) + ", " + std::to_string(first / width) + ")",
                     "is NaN or infinite, as " + std::to_string(bad) + " of " +
                         std::to_string(image.values.size() / 3) + " are: more than 1 %",
                     "export the panorama again");
  Image mended = image;
  for (int y = 0; y < image.height_px; ++y)
    for (int x = 0; x < image.width_px; ++x) {
      const float* from = image.pixel(x, y);
      float* to = mended.pixel(x, y);
      if (is_finite(from)) continue;
      if (is_sun(from)) {
        ++panorama.infinite;
        for (int c = 0; c < 3; ++c)
          if (!std::isfinite(from[c])) to[c] = brightest;
      } else {
        ++panorama.nan;
        mean_of_neighbours(image, x, y, to);
      }
    }
  image = std::move(mended);
  warn_of_mended(brightest, panorama);
}

void mend_negative(const std::string& file, Panorama& panorama) {
  double positive = 0, negative = 0;
  for (const float value : panorama.radiance.values)
    (value > 0 ? positive : negative) += std::fabs(static_cast<double>(value));
  if (positive == 0)
    throw InputError(file, "", "is all black: nothing would be lit", "leave it out, or export it again");
  if (negative == 0) return;
  const std::string share = std::to_string(100 * negative / positive) + " % of the light";
  if (negative > kMostMended * positive)
    throw InputError(file, "", "has negative values of " + share + ": more than 1 %",
                     "export it again without a look or a filter that sharpens");
  for (size_t i = 0; i < panorama.radiance.values.size(); i += 3) {
    float* rgb = &panorama.radiance.values[i];
    panorama.negative += rgb[0] < 0 || rgb[1] < 0 || rgb[2] < 0;
    for (int c = 0; c < 3; ++c) rgb[c] = std::max(rgb[c], 0.0f);
  }
  panorama.warnings.push_back(std::to_string(panorama.negative) + " texels were negative (" + share +
                              ") and are now 0");
}

/// Integers end at 1, where a sky goes on to 10 and a sun to 100,000.
void decode_integers(const ImageFileInfo& info, Panorama& panorama) {
  if (!info.says_linear)
    for (float& value : panorama.radiance.values) value = srgb_to_linear(value);
  panorama.warnings.push_back(
      "holds " + std::to_string(info.bits) + "-bit values, " +
      (info.says_linear ? "linear as it says itself" : "decoded from sRGB") +
      ": nothing in it is brighter than white, so it has no sun and soft shadows only");
}

}  // namespace

Panorama read_panorama(const std::filesystem::path& file) {
  ImageFileInfo info;
  Image image = read_image(file, &info);
  if (info.orientation != 1) image = upright(image, info.orientation);
  const std::string name = file.string();
  if (std::fabs(static_cast<double>(image.width_px) / (2.0 * image.height_px) - 1) > 0.01)
    throw shape_error(name, image.width_px, image.height_px);
  Panorama panorama;
  panorama.sha256 = sha256_of_file(file);
  panorama.radiance = three_channels(image);
  panorama.values = !info.is_float ? std::to_string(info.bits) + " bits" : info.bits == 16 ? "half" : "float";
  if (image.width_px != 2 * image.height_px)
    panorama.warnings.push_back(std::to_string(image.width_px) + " x " + std::to_string(image.height_px) +
                                " is taken as a whole sphere");
  if (!info.is_float) decode_integers(info, panorama);
  mend_what_is_not_finite(name, panorama);
  if (image.channels >= 3) convert_primaries(file, panorama.radiance, panorama.warnings);
  mend_negative(name, panorama);
  return panorama;
}

}  // namespace ohb::environments
