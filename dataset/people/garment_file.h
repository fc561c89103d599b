// Things worn on the base mesh (clothes, hair, eyes, brows): .mhclo with its .obj and .mhmat.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/scan.h"

namespace ohb::people {

/// Where a vertex of a garment sits: position = sum of weights[i] base[vertices[i]] + offset x scale.
struct Anchor {
  std::array<uint32_t, 3> vertices;
  std::array<float, 3> weights;  // sum 1, may be negative
  Vec3f offset;
};

/// The garment's size along an axis on the body that it was made for: s = |B_a - B_b| / made_for.
struct ScaleLine {
  uint32_t a = 0, b = 0;
  float made_for = 1;
};

/// What a .mhmat says that a diffuse picture needs.
struct AssetMaterial {
  std::filesystem::path file;
  std::filesystem::path diffuse;  // picture, sRGB; empty: diffuse_colour alone
  Vec3f diffuse_colour{1, 1, 1};  // sRGB
};

struct Garment {
  std::filesystem::path file;
  std::string name;
  Scan mesh;                                      // faces and UVs; positions are of another body
  std::vector<Anchor> anchors;                    // one a position of the mesh
  std::array<std::optional<ScaleLine>, 3> scale;  // x, y, z; none: 1
  float z_depth = 50;                             // larger is further out
  std::vector<char> hides;                        // one a base vertex: 1 where the garment hides it
  AssetMaterial material;
};

/// Throws InputError, naming file and line: what is missing or malformed, an index out of range, a file that
/// leads out of `assets`, a number of lines other than the mesh has vertices.
Garment read_garment(const std::filesystem::path& assets, const std::filesystem::path& file,
                     size_t base_vertex_count);

/// Throws InputError, naming file and line.
AssetMaterial read_asset_material(const std::filesystem::path& assets, const std::filesystem::path& file);

/// The garment's vertices on a (morphed) base, in the base's unit.
std::vector<Vec3f> fitted(const Garment& garment, const std::vector<Vec3f>& base);

}  // namespace ohb::people
