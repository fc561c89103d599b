#include "dataset/exports/encodings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "dataset/model/error.h"
#include "dataset/model/map_table.h"

namespace ohb::exports {
namespace {

/// encode(value) where the mask is above 0; 0 elsewhere.
template <class Encode>
Image encoded(const Image& image, const Image& mask, const Encode& encode) {
  Image out(image.width_px, image.height_px, image.channels);
  const auto channels = static_cast<size_t>(image.channels);
  for (size_t i = 0; i < out.values.size(); ++i)
    if (mask.values[i / channels] > 0) out.values[i] = std::clamp(encode(image.values[i]), 0.0f, 1.0f);
  return out;
}

}  // namespace

float displacement_range_cm(const Sample& sample, const std::string& file) {
  for (const auto& [name, value] : sample.attributes)
    if (name == "ohb:displacementRange_cm")
      if (const float range = std::strtof(value.c_str(), nullptr); std::isfinite(range) && range > 0)
        return range;
  throw InputError(file, "attribute ohb:displacementRange_cm", "is missing or no length",
                   "render the sample again");
}

std::vector<EncodedMap> encoded_maps(const Sample& sample, const std::string& file) {
  const float range_cm = displacement_range_cm(sample, file);
  for (const SampleLight& light : sample.lights)
    if (light.name.empty() || light.name.find('/') != std::string::npos)
      throw InputError(file, "light '" + light.name + "'", "names no file", "render the sample again");
  std::vector<EncodedMap> maps = {{"mask", sample.mask}};
  const auto add = [&](const std::string& name, const Image& image, PngEncoding png) {
    maps.push_back({name, encoded(image, sample.mask, [&](float v) { return png_value(png, v, range_cm); })});
  };
  for (const SampleMap& map : sample_maps())
    if (map.image != &Sample::mask && map.png != PngEncoding::kNone)
      add(map.name, sample.*map.image, map.png);
  for (const SampleLight& light : sample.lights)
    add("relit_" + light.name, light.radiance, PngEncoding::kSrgb);
  return maps;
}

std::string encodings_text(int bits) {
  const std::string most = std::to_string((1 << bits) - 1);
  std::string materials;
  for (const MaterialMap& map : kMaterialMaps)
    materials += fmt::format("| `{0}.png` | {0} = v: {1} |\n", map.name, map.rule);
  return "| file | value v = stored / " + most +
         " |\n|---|---|\n"
         "| `mask.png` | coverage of the pixel |\n"
         "| `normal.png` | n = 2 v - 1, camera space: red +X right, green +Y up, blue +Z to the viewer |\n"
         "| `diffuse.png` | sRGB-encoded albedo: linear = srgb_to_linear(v) |\n" +
         materials +
         "| `displacement.png` | cm from the plane z = 0, positive towards the camera: d = (2 v - 1) r, r is "
         "`displacement_range_cm` in `sample.json` |\n"
         "| `relit_<light>.png` | sRGB-encoded radiance, clipped at 1, premultiplied by the mask |\n\n"
         "Values are rounded to the nearest; the background is 0 in all. sRGB is the piecewise curve of IEC "
         "61966-2-1. "
         "Maps are averages over the covered part of a pixel; the EXR samples hold them unrounded.\n";
}

ByteImage thumbnail(const Image& image, int size_px) {
  const int width = std::min(size_px, image.width_px);
  const int height = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(image.height_px) * width / image.width_px)));
  ByteImage out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int left = x * image.width_px / width,
                right = std::max(left + 1, (x + 1) * image.width_px / width);
      const int top = y * image.height_px / height,
                bottom = std::max(top + 1, (y + 1) * image.height_px / height);
      for (int c = 0; c < 3; ++c) {
        float sum = 0;
        for (int v = top; v < bottom; ++v)
          for (int u = left; u < right; ++u) sum += image.pixel(u, v)[image.channels == 3 ? c : 0];
        out.values[3 * (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) +
                   static_cast<size_t>(c)] =
            static_cast<uint8_t>(
                std::lround(255 * sum / static_cast<float>((right - left) * (bottom - top))));
      }
    }
  return out;
}

}  // namespace ohb::exports
