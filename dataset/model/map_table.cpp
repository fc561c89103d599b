#include "dataset/model/map_table.h"

#include <algorithm>

#include "dataset/model/colour.h"

namespace ohb {

float png_value(PngEncoding encoding, float value, float range_cm) {
  switch (encoding) {
    case PngEncoding::kSrgb:
      return linear_to_srgb(std::clamp(value, 0.0f, 1.0f));
    case PngEncoding::kSigned:
      return 0.5f + 0.5f * value;
    case PngEncoding::kLength:
      return 0.5f + 0.5f * value / range_cm;
    case PngEncoding::kNone:
    case PngEncoding::kPlain:
      break;
  }
  return value;
}

namespace {

std::vector<std::string> letters(const std::string& names) {
  std::vector<std::string> channels;
  for (const char name : names) channels.emplace_back(1, name);
  return channels;
}

std::vector<SampleMap> all_sample_maps() {
  using Type = ExrPart::Type;
  std::vector<SampleMap> maps = {
      {"mask", &Sample::mask, letters("A"), Type::kHalf, PngEncoding::kPlain, "share",
       "coverage of the pixel, 0 to 1"},
      {"normal", &Sample::normal, letters("XYZ"), Type::kFloat, PngEncoding::kSigned, "unit vector",
       "camera space: +X right, +Y up, +Z to the viewer; 0 where mask is 0"},
      {"diffuse", &Sample::diffuse, letters("RGB"), Type::kHalf, PngEncoding::kSrgb, "albedo",
       "linear Rec. 709"}};
  for (const MaterialMap& map : kMaterialMaps)
    maps.push_back({map.name, map.pixels, letters("Y"), Type::kHalf, PngEncoding::kPlain, "1", map.rule});
  maps.push_back({"displacement", &Sample::displacement, letters("Y"), Type::kFloat, PngEncoding::kLength,
                  "cm", "from the plane z = 0 through the subject's middle, positive towards the camera"});
  const std::vector<std::string> classes(kClassNames.begin(), kClassNames.end());
  maps.push_back({"classes", &Sample::classes, classes, Type::kHalf, PngEncoding::kNone, "share",
                  "of each class in the covered part"});
  return maps;
}

}  // namespace

const std::vector<SampleMap>& sample_maps() {
  static const std::vector<SampleMap> maps = all_sample_maps();
  return maps;
}

}  // namespace ohb
