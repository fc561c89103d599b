// The material maps as tensors, in the encodings of the learner, and the one list of them.
#pragma once

#include <array>
#include <string_view>

#include "dataset/model/model.h"
#include "dataset/model/sample.h"
#include "learner/torch.h"

namespace ohb::learner {

/// Batches of maps, each (B, C, H, W), float32 (or float64 in tests), contiguous. Values where the mask is 0
/// mean nothing.
struct MaterialMaps {
  torch::Tensor normal;        // C = 3, camera space, +X right, +Y up, +Z to the viewer; signed
  torch::Tensor diffuse;       // C = 3, linear Rec. 709
  torch::Tensor roughness;     // C = 1, perceptual
  torch::Tensor specular;      // C = 1, S: F0 = srgb_to_linear(S)
  torch::Tensor sss;           // C = 1, Principled subsurface weight
  torch::Tensor displacement;  // C = 1, in halves of the frame's width, positive to the viewer
};

/// What the learner needs to know of a map to read, estimate, score and write it.
struct LearnedMap {
  const char* name;  // of the sample's part, and of the files that `estimate` writes
  torch::Tensor MaterialMaps::*tensor;
  Image Sample::*image;
  Image TextureSet::*texels;  // where relights look it up; null: it shapes the surface instead
  std::string_view channels;  // names in EXR, a letter each
  const char* column;         // heading in the tables of `evaluate`
  std::string_view encoding;  // of its PNG, as maps.json names it: offset, srgb, value or srgb_f0
  const char* convention;     // what maps.json says of it
  double span = 0;  // largest less smallest value in assets/materials.xml, of the rss network's maps; else 0
};

/// Whatever goes over all maps goes over this list. The rss network's channels are in its order.
constexpr std::array<LearnedMap, 6> kMaps = {{
    {"normal", &MaterialMaps::normal, &Sample::normal, nullptr, "XYZ", "N", "offset",
     "camera space: +X right, +Y up, +Z to the viewer; (n + 1) / 2"},
    {"diffuse", &MaterialMaps::diffuse, &Sample::diffuse, &TextureSet::albedo, "RGB", "D", "srgb",
     "Rec. 709, sRGB-encoded"},
    {"roughness", &MaterialMaps::roughness, &Sample::roughness, &TextureSet::roughness, "Y", "R", "value",
     "perceptual; GGX alpha = roughness squared", 0.6},
    {"specular", &MaterialMaps::specular, &Sample::specular, &TextureSet::specular, "Y", "S", "srgb_f0",
     "F0 = sRGB_to_linear(S)", 0.079},
    {"sss", &MaterialMaps::sss, &Sample::sss, &TextureSet::sss, "Y", "SSS", "value",
     "Principled subsurface; scattering radius = sss x (1.0, 0.2, 0.1) cm", 0.08},
    {"displacement", &MaterialMaps::displacement, &Sample::displacement, nullptr, "Y", "Disp", "offset",
     "0.5 + d / (2 r_cm), d in cm from the plane z = 0, positive towards the camera"},
}};

constexpr bool is_of_rss(const LearnedMap& map) {
  return map.span > 0;
}

/// Channels of the rss network, one a map.
constexpr int64_t rss_channels() {
  int64_t count = 0;
  for (const LearnedMap& map : kMaps) count += is_of_rss(map) ? 1 : 0;
  return count;
}

}  // namespace ohb::learner
