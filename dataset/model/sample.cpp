#include "dataset/model/sample.h"

#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <cmath>

#include "dataset/model/error.h"
#include "dataset/model/map_table.h"

namespace ohb {
namespace {

constexpr const char* kLightPrefix = "relit.";

// OpenEXR stores channels by name; they are read back in that order, not in the order of writing.
Image in_channel_order(const ExrPart& part, const std::vector<std::string>& channels,
                       const std::string& file) {
  std::vector<size_t> source;
  for (const std::string& channel : channels) {
    size_t i = 0;
    while (i < part.channels.size() && part.channels[i] != channel) ++i;
    if (i == part.channels.size())
      throw InputError(file, "part '" + part.name + "'", "has no channel '" + channel + "'",
                       "render the sample again with this version");
    source.push_back(i);
  }
  Image image(part.image.width_px, part.image.height_px, static_cast<int>(channels.size()));
  const size_t pixels = static_cast<size_t>(image.width_px) * image.height_px;
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < source.size(); ++c)
      image.values[p * source.size() + c] = part.image.values[p * part.channels.size() + source[c]];
  return image;
}

void check(const Image& image, const Image& mask, const std::string& part, const std::string& file) {
  if (image.width_px != mask.width_px || image.height_px != mask.height_px)
    throw InputError(file, "part '" + part + "'", "has another size than the mask",
                     "render the sample again with this version");
  for (size_t i = 0; i < image.values.size(); ++i)
    if (!std::isfinite(image.values[i])) {
      const size_t pixel = i / image.channels;
      throw InputError(file,
                       "part '" + part + "', pixel (" + std::to_string(pixel % image.width_px) + ", " +
                           std::to_string(pixel / image.width_px) + ")",
                       "is NaN or infinite", "render the sample again");
    }
}

}  // namespace

namespace {

/// The noise of shadows that were guessed (renderer/shadow_guess.h) leaves single pixels below 0, where no
/// light is: 0 is nearer to the truth, and logarithms need it.
Image without_negatives(Image radiance) {
  for (float& value : radiance.values)
    if (value < 0) value = 0;
  return radiance;
}

}  // namespace

void write_sample(const std::filesystem::path& file, const Sample& sample) {
  std::vector<ExrPart> parts;
  for (const SampleMap& map : sample_maps())
    parts.push_back({map.name, map.channels, map.type, sample.*map.image});
  for (const SampleLight& light : sample.lights)
    parts.push_back({kLightPrefix + light.name,
                     {"R", "G", "B"},
                     ExrPart::Type::kHalf,
                     without_negatives(light.radiance)});
  write_exr(file, parts, sample.attributes);
}

Sample read_sample(const std::filesystem::path& file) {
  Sample sample;
  ExrAttributes attributes;
  const std::vector<ExrPart> parts = read_exr(file, &attributes);
  for (const SampleMap& map : sample_maps()) {
    sample.*map.image = in_channel_order(find_part(parts, map.name, file), map.channels, file.string());
    check(sample.*map.image, sample.mask, map.name, file.string());
  }
  for (const ExrPart& part : parts) {
    if (part.name.rfind(kLightPrefix, 0) != 0) continue;
    SampleLight light{part.name.substr(std::string(kLightPrefix).size()),
                      in_channel_order(part, {"R", "G", "B"}, file.string())};
    check(light.radiance, sample.mask, part.name, file.string());
    sample.lights.push_back(std::move(light));
  }
  for (auto& attribute : attributes)
    if (attribute.first.rfind("ohb:", 0) == 0) sample.attributes.push_back(std::move(attribute));
  return sample;
}

ExrAttributes read_sample_attributes(const std::filesystem::path& file) {
  try {
    const Imf::MultiPartInputFile input(file.c_str(), 0, false);
    ExrAttributes attributes;
    const Imf::Header& header = input.header(0);
    for (auto i = header.begin(); i != header.end(); ++i)
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute()))
        if (std::string(i.name()).rfind("ohb:", 0) == 0) attributes.emplace_back(i.name(), text->value());
    return attributes;
  } catch (const std::exception& error) {
    throw InputError(file.string(), "", std::string("is no sample that can be read: ") + error.what(),
                     "render the sample again");
  }
}

}  // namespace ohb
