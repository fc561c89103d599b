// A sample: one view of one model, as one multi-part EXR. Written by `render`, read by the learner.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dataset/model/image.h"

namespace ohb {

struct SampleLight {
  std::string name;  // the environment's name, or "point0", ...
  Image radiance;    // 3, linear, premultiplied by coverage, background black
};

/// Maps are averages over the covered part of each pixel, never mixed with the background; where `mask` is 0
/// they are 0. Camera space: +X right, +Y up, +Z to the viewer.
struct Sample {
  Image mask;          // 1, coverage in [0,1]
  Image normal;        // 3, float, unit length where mask > 0
  Image diffuse;       // 3, linear albedo
  Image roughness;     // 1
  Image specular;      // 1, S (see material_table.h)
  Image sss;           // 1
  Image displacement;  // 1, float, cm from the world centre plane, positive towards the camera
  Image classes;       // 4, share of each class in the covered part, in the order of kClassNames
  std::vector<SampleLight> lights;
  /// ohb:human, ohb:view, ohb:viewCount, ohb:seed, ohb:spp, ohb:displacementRange_cm, ohb:camera..., fixed
  /// order.
  ExrAttributes attributes;
};

/// Parts: sample_maps() (map_table.h), relit.<light>... in half, radiance below 0 as 0. Equal samples give
/// equal bytes.
void write_sample(const std::filesystem::path& file, const Sample& sample);

/// Its attributes alone, from the header: a small part of the time. Throws InputError if that cannot be read.
ExrAttributes read_sample_attributes(const std::filesystem::path& file);

/// Throws InputError for a missing part, a part of another size, or NaN values.
Sample read_sample(const std::filesystem::path& file);

}  // namespace ohb
