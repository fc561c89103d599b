// Hands a scene to Blender: a folder of raw arrays, maps and scene.json that
// blender_addon/validation_scene.py builds and renders in Cycles of Blender 3.4 (v1) or 4.5 (v2).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/camera.h"
#include "dataset/model/environment.h"
#include "dataset/model/model.h"
#include "renderer/render.h"

namespace ohb::validation {

/// One round of images over all or some pixels.
struct CyclesPass {
  int spp = 128;                          // at most kMaxCyclesSpp
  std::vector<uint32_t> seeds;            // below 2^31; one image each
  std::vector<renderer::PixelBox> boxes;  // apart from each other; none: the whole image
  double adaptive_threshold = 0;          // above 0: Cycles stops pixels early, which biases it a little
};
constexpr int kMaxCyclesSpp = 8192;  // Cycles' sampling tables end there

/// Where the random numbers of Cycles 3.4 come from. 4.5 keeps its default, tables of another make.
enum class CyclesNumbers {
  kScrambled,  // Sobol points that each seed, pixel and dimension scrambles anew: means over seeds converge
  kTables,     // its default and faster: 256 fixed patterns that seeds only choose from
};

struct CyclesScene {
  const Model* model = nullptr;
  const Environment* environment = nullptr;  // null: black
  std::vector<renderer::PointLight> points;
  Camera camera;
  double turn_rad = 0;  // of the subject about +Y
  int size_px = 256;
  int max_bounces = 32;  // of every kind; cut-outs pass 256
  renderer::ShadingModel shading = renderer::ShadingModel::kV1;
  bool subsurface = true;  // false: diffuse reflection instead
  CyclesNumbers numbers = CyclesNumbers::kScrambled;
  std::vector<CyclesPass> passes;
  std::string kept;  // file name of the scene as a .blend, in `renders`; empty: it is not kept
};

/// `count` seeds for Cycles, 31 bits, hashed from ours (its sampler mixes the seed by XOR: 1, 2, 3 would do
/// less well), all different.
std::vector<uint32_t> cycles_seeds(uint64_t seed, int count);

/// Writes scene.json, positions.f32 (metres; Blender's axes (x, -z, y)), triangles.i32, corner_uvs.f32 (one a
/// triangle corner, v up), sets.i32 (one a triangle), maps/<set>_<map>.exr (half, the precision that our
/// renderer's texels have; a constant map is one texel) and environment.exr (float) into an existing folder.
/// Triangles that name a position twice are left out. Throws as write_exr and write_file_atomically.
void write_cycles_scene(const std::filesystem::path& folder, const CyclesScene& scene);

}  // namespace ohb::validation
