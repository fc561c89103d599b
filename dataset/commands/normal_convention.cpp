#include "dataset/commands/normal_convention.h"

#include <algorithm>
#include <cmath>

namespace ohb::commands {
namespace {

constexpr double kClearRatio = 3;
/// Mean slope difference between neighbours below which a map is flat: half an 8-bit step.
constexpr double kFlatSlope = 0.5 / 127.5;

constexpr int kLevels = 4;
constexpr size_t kEnoughTexels = 2000;

struct Slope {
  float p = 0, q = 0;
};

/// Slopes of the surface that the normals belong to, and the chart of each texel.
struct SlopeField {
  int width_px, height_px;
  std::vector<Slope> slope;
  std::vector<uint32_t> region;
};

SlopeField slopes_of(const Image& image, const std::vector<uint32_t>& region) {
  SlopeField field{image.width_px, image.height_px, std::vector<Slope>(region.size()), region};
  for (size_t i = 0; i < region.size(); ++i) {
    const float* rgb = &image.values[i * static_cast<size_t>(image.channels)];
    const float z = std::max(2 * rgb[2] - 1, 0.1f);
    field.slope[i] = {-(2 * rgb[0] - 1) / z, -(2 * rgb[1] - 1) / z};
  }
  return field;
}

/// Means of two by two texels; those of several charts belong to none.
SlopeField halved(const SlopeField& fine) {
  const int w = fine.width_px / 2, h = fine.height_px / 2;
  const size_t count = static_cast<size_t>(w) * h;
  SlopeField field{w, h, std::vector<Slope>(count), std::vector<uint32_t>(count, kNoRegion)};
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const size_t to = static_cast<size_t>(y) * w + x,
                   from = static_cast<size_t>(2 * y) * fine.width_px + 2 * x;
      const size_t row = static_cast<size_t>(fine.width_px);
      bool is_one = true;
      for (size_t i : {from, from + 1, from + row, from + row + 1}) {
        field.slope[to].p += 0.25f * fine.slope[i].p;
        field.slope[to].q += 0.25f * fine.slope[i].q;
        is_one &= fine.region[i] == fine.region[from];
      }
      if (is_one) field.region[to] = fine.region[from];
    }
  return field;
}

NormalConventionResult measure(const SlopeField& field) {
  NormalConventionResult result;
  const int w = field.width_px, h = field.height_px;
  double relief = 0;
  for (int y = 1; y + 1 < h; ++y)
    for (int x = 1; x + 1 < w; ++x) {
      const size_t row = static_cast<size_t>(w), i = static_cast<size_t>(y) * row + static_cast<size_t>(x);
      const uint32_t chart = field.region[i];
      if (chart == kNoRegion || field.region[i - 1] != chart || field.region[i + 1] != chart ||
          field.region[i - row] != chart || field.region[i + row] != chart)
        continue;
      const double dp_dv = 0.5 * (field.slope[i - row].p - field.slope[i + row].p);
      const double dq_du = 0.5 * (field.slope[i + 1].q - field.slope[i - 1].q);
      result.curl_opengl += std::abs(dp_dv - dq_du);
      result.curl_directx += std::abs(dp_dv + dq_du);
      relief += std::abs(dp_dv) + std::abs(dq_du);
      ++result.texels;
    }
  if (result.texels == 0) return result;
  const double count = static_cast<double>(result.texels);
  result.curl_opengl /= count;
  result.curl_directx /= count;
  const double low = std::min(result.curl_opengl, result.curl_directx);
  const double high = std::max(result.curl_opengl, result.curl_directx);
  result.ratio = high / std::max(low, 1e-9);
  if (relief / count < kFlatSlope) {
    result.convention = NormalConvention::kFlat;
  } else if (result.ratio >= kClearRatio) {
    result.convention = result.leans_to_opengl() ? NormalConvention::kOpenGl : NormalConvention::kDirectX;
  }
  return result;
}

}  // namespace

const char* name_of(NormalConvention convention) {
  switch (convention) {
    case NormalConvention::kOpenGl:
      return "OpenGL";
    case NormalConvention::kDirectX:
      return "DirectX";
    case NormalConvention::kFlat:
      return "flat";
    default:
      return "unclear";
  }
}

NormalConventionResult detect_normal_convention(const Image& image, const std::vector<uint32_t>& region) {
  const size_t texels = static_cast<size_t>(image.width_px) * image.height_px;
  if (image.channels < 3 || region.size() != texels) return {};
  SlopeField field = slopes_of(image, region);
  NormalConventionResult best = measure(field);
  for (int level = 1; level < kLevels; ++level) {
    field = halved(field);
    NormalConventionResult coarse = measure(field);
    coarse.level = level;
    if (coarse.texels < kEnoughTexels) break;
    const bool is_flat = coarse.convention == NormalConvention::kFlat;
    if (!is_flat && coarse.ratio > best.ratio) best = coarse;
  }
  return best;
}

}  // namespace ohb::commands
