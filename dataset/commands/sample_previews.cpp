#include "dataset/commands/sample_previews.h"

#include <algorithm>
#include <cstdlib>
#include <functional>

#include "dataset/model/colour.h"
#include "dataset/model/map_table.h"

namespace ohb::commands {
namespace {

// `encode` maps one stored value to [0,1]; uncovered pixels become transparent black.
Image encoded(const Image& values, const Image& mask, const std::function<float(float)>& encode) {
  Image out(values.width_px, values.height_px, 4);
  const size_t pixels = static_cast<size_t>(values.width_px) * values.height_px;
  for (size_t p = 0; p < pixels; ++p) {
    const float alpha = mask.values[p];
    for (int c = 0; c < 3; ++c)
      out.values[4 * p + c] =
          alpha > 0 ? encode(values.values[p * values.channels + (values.channels == 3 ? c : 0)]) : 0;
    out.values[4 * p + 3] = alpha;
  }
  return out;
}

float displacement_range_cm(const Sample& sample) {
  for (const auto& [name, value] : sample.attributes)
    if (name == "ohb:displacementRange_cm") return std::strtof(value.c_str(), nullptr);
  return 100;
}

}  // namespace

Image srgb_with_alpha(const Image& linear, const Image& mask, bool premultiplied) {
  Image straight = linear;
  if (premultiplied)
    for (size_t i = 0; i < straight.values.size(); ++i)
      straight.values[i] /= std::max(mask.values[i / linear.channels], 1e-6f);
  return encoded(straight, mask, [](float v) { return linear_to_srgb(std::clamp(v, 0.0f, 1.0f)); });
}

void write_previews(const std::filesystem::path& folder, const std::string& stem, const Sample& sample) {
  const auto write = [&](const std::string& part, const Image& image) {
    write_png(folder / (stem + "." + part + ".png"), image);
  };
  const float range_cm = displacement_range_cm(sample);
  write("mask", sample.mask);
  for (const SampleMap& map : sample_maps())
    if (map.image != &Sample::mask && map.png != PngEncoding::kNone)
      write(map.name, encoded(sample.*map.image, sample.mask,
                              [&](float v) { return png_value(map.png, v, range_cm); }));
  for (const SampleLight& light : sample.lights)
    write("relit." + light.name, srgb_with_alpha(light.radiance, sample.mask, true));
}

}  // namespace ohb::commands
