#include "learner/photo.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "dataset/model/image_place.h"
#include "learner/colour_profile.h"
#include "learner/data.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

constexpr int kMinEdge_px = 16;
constexpr double kMargin = 0.05;
constexpr double kAllCovered = 0.999;     // share of the pixels
constexpr double kInvertedBorder = 0.95;  // no photograph shows a person along all four edges

std::string size_text(const Image& image) {
  return std::to_string(image.width_px) + " x " + std::to_string(image.height_px);
}

void check_finite(const Image& image, const fs::path& file) {
  for (size_t i = 0; i < image.values.size(); ++i)
    if (!std::isfinite(image.values[i])) {
      const size_t p = i / image.channels;
      throw InputError(
          file.string(),
          "pixel (" + std::to_string(p % image.width_px) + ", " + std::to_string(p / image.width_px) + ")",
          "is NaN or infinite", "repair the picture");
    }
}

Image channel_of(const Image& image, int channel) {
  Image out(image.width_px, image.height_px, 1);
  for (size_t p = 0; p < out.values.size(); ++p)
    out.values[p] = std::clamp(image.values[p * image.channels + channel], 0.0f, 1.0f);
  return out;
}

/// How many of the channels are colour: 1 or 3.
int colour_channels(const Image& image, const ImageFileInfo& info, const fs::path& file) {
  const int colours = image.channels - (info.has_alpha ? 1 : 0);
  if (colours == 1 || colours == 3) return colours;
  if (colours == 2 || (colours == 4 && info.has_alpha) || colours > 4)
    throw InputError(file.string(), "", "has " + std::to_string(image.channels) + " channels",
                     "export it as grey or RGB, with alpha or without");
  throw InputError(file.string(), "", "has 4 channels of which none is alpha (CMYK?)", "export it as RGB");
}

/// Overlaps of output pixels with input pixels along one axis: `count` outputs cover [first, first + side).
struct Tap {
  int index;
  float weight;
};
std::vector<std::vector<Tap>> taps_of(double first, double side, int count, int length) {
  std::vector<std::vector<Tap>> taps(static_cast<size_t>(count));
  const double step = side / count;
  for (int o = 0; o < count; ++o) {
    // A window of at least one input pixel: smaller ones would be nearest-neighbour, this is bilinear.
    const double centre = first + (o + 0.5) * step, half = 0.5 * std::max(step, 1.0);
    const double begin = centre - half, end = centre + half;
    for (int i = static_cast<int>(std::floor(begin)); i < end; ++i) {
      const double overlap = std::min(end, i + 1.0) - std::max(begin, static_cast<double>(i));
      // Weights sum to 1 with what lies beyond the edge, which counts as empty.
      if (overlap > 0 && i >= 0 && i < length)
        taps[o].push_back({i, static_cast<float>(overlap / (2 * half))});
    }
  }
  return taps;
}

double covered_share(const Image& mask) {
  const auto covered =
      std::count_if(mask.values.begin(), mask.values.end(), [](float m) { return m > 0.5f; });
  return static_cast<double>(covered) / static_cast<double>(mask.values.size());
}

/// Of the pixels along the four edges.
double covered_border_share(const Image& mask) {
  size_t pixels = 0, covered = 0;
  for (int y = 0; y < mask.height_px; ++y) {
    const bool is_edge_row = y == 0 || y == mask.height_px - 1;
    for (int x = 0; x < mask.width_px; x += is_edge_row ? 1 : mask.width_px - 1) {
      ++pixels;
      covered += *mask.pixel(x, y) > 0.5f;
    }
  }
  return static_cast<double>(covered) / static_cast<double>(pixels);
}

/// Editors save opaque masks with an alpha of 1 everywhere: it then says nothing.
Image read_mask(const fs::path& file) {
  ImageFileInfo info;
  const Image image = read_image(file, &info);
  if (image.width_px < 2 || image.height_px < 2)
    throw InputError(file.string(), "", "is only " + size_text(image) + " pixels",
                     "give a mask of the photo's size");
  check_finite(image, file);
  const int colours = colour_channels(image, info, file);
  Image mask = channel_of(image, info.has_alpha ? image.channels - 1 : 0);
  const bool is_opaque = std::all_of(mask.values.begin(), mask.values.end(), [](float a) { return a >= 1; });
  if (!info.has_alpha || is_opaque)
    for (size_t p = 0; p < mask.values.size(); ++p) {
      float sum = 0;
      for (int c = 0; c < colours; ++c) sum += image.values[p * image.channels + c];
      mask.values[p] = std::clamp(sum / static_cast<float>(colours), 0.0f, 1.0f);
    }
  return upright(mask, info.orientation);
}

}  // namespace

Photo read_photo(const fs::path& file) {
  ImageFileInfo info;
  Image image = read_image(file, &info);
  if (image.width_px < kMinEdge_px || image.height_px < kMinEdge_px)
    throw InputError(file.string(), "", "is only " + size_text(image) + " pixels", "give a larger picture");
  const int colours = colour_channels(image, info, file);
  check_finite(image, file);
  if (!info.is_float && colours == 3 && to_srgb(image, colour_profile_of(file)) == ProfileUse::kUnreadable)
    spdlog::warn("{}: its colour profile cannot be read; its colours are taken as sRGB", file.string());
  image = upright(image, info.orientation);
  Photo photo;
  if (info.has_alpha) photo.alpha = channel_of(image, image.channels - 1);
  photo.linear = Image(image.width_px, image.height_px, 3);
  const size_t pixels = static_cast<size_t>(image.width_px) * image.height_px;
  for (size_t p = 0; p < pixels; ++p)
    for (int c = 0; c < 3; ++c) {
      const float stored = image.values[p * image.channels + (colours == 3 ? c : 0)];
      photo.linear.values[3 * p + c] = info.is_float ? std::max(0.0f, stored) : srgb_to_linear(stored);
    }
  return photo;
}

bool has_cutout(const Photo& photo) {
  const auto& alpha = photo.alpha.values;
  return std::any_of(alpha.begin(), alpha.end(), [](float a) { return a < 1; });
}

Image mask_of(const Photo& photo, const fs::path& photo_file, const std::optional<fs::path>& mask_file) {
  const Image mask = mask_file ? read_mask(*mask_file) : photo.alpha;
  const fs::path& file = mask_file ? *mask_file : photo_file;
  if (mask.values.empty())
    throw InputError(photo_file.string(), "", "has no alpha, and there is no --mask",
                     "cut the person out (for example with rembg) and give the result, or its mask");
  if (mask.width_px != photo.linear.width_px || mask.height_px != photo.linear.height_px)
    throw InputError(file.string(), "",
                     "is " + size_text(mask) + ", the photo is " + size_text(photo.linear) + " (upright)",
                     "give a mask of the photo's size");
  const double covered = covered_share(mask);
  if (covered == 0)
    throw InputError(file.string(), "", "covers nothing: no pixel is brighter than a half",
                     "give a mask that is white on the person");
  if (covered > kAllCovered)
    throw InputError(
        file.string(), "",
        std::string(mask_file ? "covers everything" : "is opaque everywhere: its alpha covers everything") +
            ": the person is not cut out",
        "give a mask that is white on the person and black elsewhere");
  if (covered_border_share(mask) > kInvertedBorder)
    throw InputError(file.string(), "",
                     "covers the edge of the picture all around, but not its middle: it is inverted",
                     "give a mask that is white on the person and black elsewhere");
  return mask;
}

Crop crop_around(const Image& mask) {
  int left = mask.width_px, right = -1, top = mask.height_px, bottom = -1;
  for (int y = 0; y < mask.height_px; ++y)
    for (int x = 0; x < mask.width_px; ++x)
      if (*mask.pixel(x, y) > 0.5f) {
        left = std::min(left, x), right = std::max(right, x);
        top = std::min(top, y), bottom = std::max(bottom, y);
      }
  const double width = right - left + 1, height = bottom - top + 1;
  const double side = std::max(width, height) * (1 + 2 * kMargin);
  return {left + 0.5 * (width - side), top + 0.5 * (height - side), side};
}

Foreground foreground_of(const Photo& photo, const Image& mask, const Crop& crop, int size_px) {
  const auto columns = taps_of(crop.left_px, crop.side_px, size_px, mask.width_px);
  const auto rows = taps_of(crop.top_px, crop.side_px, size_px, mask.height_px);
  torch::Tensor srgb = torch::zeros({1, 3, size_px, size_px}),
                coverage = torch::zeros({1, 1, size_px, size_px});
  auto colour_at = srgb.accessor<float, 4>();
  auto coverage_at = coverage.accessor<float, 4>();
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      double sum[3] = {}, alpha = 0;
      for (const Tap& row : rows[y])
        for (const Tap& column : columns[x]) {
          const double w =
              static_cast<double>(row.weight) * column.weight * *mask.pixel(column.index, row.index);
          alpha += w;
          for (int c = 0; c < 3; ++c) sum[c] += w * photo.linear.pixel(column.index, row.index)[c];
        }
      if (alpha <= 0) continue;
      coverage_at[0][0][y][x] = static_cast<float>(alpha);
      for (int c = 0; c < 3; ++c)
        colour_at[0][c][y][x] = static_cast<float>(
            alpha * linear_to_srgb(std::clamp(static_cast<float>(sum[c] / alpha), 0.0f, 1.0f)));
    }
  return {network_input(srgb, coverage), coverage};
}

}  // namespace ohb::learner
