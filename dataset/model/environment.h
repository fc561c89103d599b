// Latitude-longitude environment maps.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb {

/// Linear Rec. 709 radiance, 3 channels, row 0 at the top (+Y). Our axes: u = 1/2 + atan2(z, x) / 2 pi,
/// v from the top = acos(y) / pi; so the image centre is +X and +Z is at u = 3/4, as Cycles sees it in
/// Blender's axes (x, -z, y).
struct Environment {
  std::string name;  // the file's stem
  std::filesystem::path file;
  std::string sha256;
  Image radiance;
  size_t mended_values = 0;           // negative ones of the file, set to 0
  std::vector<std::string> warnings;  // about what the file can hold; read_environment logs them too
};

/// EXR and HDR are taken as linear; integers (PNG, JPEG, TIFF; 8 or 16 bits) are decoded from sRGB, unless a
/// PNG says that they are linear, with a warning that they hold no sun. Pictures are turned by their EXIF
/// orientation; grey ones light grey; alpha is not used.
/// Throws InputError: not an image, aspect ratio other than 2:1, NaN, infinite or negative texels (naming the
/// first one and how many), all black. Negative values that together are below 1e-4 of the light, as
/// resampling filters leave them beside bright spots, are set to 0 instead.
Environment read_environment(const std::filesystem::path& file);

/// Texture coordinates (u, v from the top) of a unit direction.
Vec2f environment_uv(Vec3f direction);
/// The unit direction of texture coordinates, inverse of environment_uv.
Vec3f environment_direction(Vec2f uv);

/// Direction (unit, world) of the brightest texel's centre: the test pixel of the manifest.
Vec3f brightest_direction(const Environment& environment);

}  // namespace ohb
