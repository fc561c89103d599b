// The body: MakeHuman's base mesh, its macro sliders, and their morph targets.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "dataset/model/scan.h"
#include "dataset/people/morph_target.h"

namespace ohb::people {

/// MakeHuman's base mesh: decimetres, Y up, facing +Z; skin, helpers and joints in one list of vertices.
struct BaseMesh {
  Scan mesh;
  std::vector<uint32_t> skin_faces;       // those of group "body"
  std::vector<uint32_t> ground_vertices;  // of group "joint-ground"
};

/// Throws InputError: not a mesh, no group "body" or "joint-ground", faces without UVs.
BaseMesh read_base_mesh(const std::filesystem::path& file);

/// MakeHuman's macro sliders, 0 to 1; the races' shares sum to 1.
struct BodySliders {
  float male = 0;
  float years = 25;  // 10 to 90
  float muscle = .5f, weight = .5f, height = .5f, proportions = .5f;
  float cup = .5f, firmness = .5f;
  float african = 0, asian = 0, caucasian = 1;
};

/// Name below the targets' folder, and weight.
using WeightedTarget = std::pair<std::string, float>;

/// The targets of the sliders: for each file the product of the shares that its name lists. Those of no
/// weight are left out; some of the names have no file, which counts as zero.
std::vector<WeightedTarget> macro_targets(const BodySliders& sliders);

/// The base's vertices (dm) moved by the targets.
std::vector<Vec3f> morphed(const BaseMesh& base, const MorphTargets& library,
                           const std::vector<WeightedTarget>& targets);

/// Height of the skin, dm.
float height_of(const BaseMesh& base, const std::vector<Vec3f>& positions);

}  // namespace ohb::people
