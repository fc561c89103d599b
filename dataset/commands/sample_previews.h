// PNG pictures of a sample, for eyes only.
#pragma once

#include <filesystem>
#include <string>

#include "dataset/model/sample.h"

namespace ohb::commands {

/// Writes <stem>.<part>.png for every map and light into `folder`: colours sRGB-encoded with alpha, radiance
/// clipped at 1, normals as (n + 1) / 2, displacement as 0.5 + d / (2 r) with r from the attributes.
void write_previews(const std::filesystem::path& folder, const std::string& stem, const Sample& sample);

/// Linear colour (3 channels) premultiplied or not -> sRGB with `mask` as alpha (4 channels).
Image srgb_with_alpha(const Image& linear, const Image& mask, bool premultiplied);

}  // namespace ohb::commands
