// A renderable model: the mesh in canonical axes and centimetres, and the maps of each texture set.
// This is what `bake` writes and what `render` and `validate` read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb {

/// The UV maps of one UV layout (a scan has one set; a model of parts has one a part), v up, texel
/// (column i, row r from the top) centred at u = (i + .5) / width, v = 1 - (r + .5) / height, REPEAT.
/// All maps of a set have the same size.
struct TextureSet {
  std::string name;
  Image albedo;        // 3, linear Rec. 709
  Image alpha;         // 1, cut-out opacity; empty: opaque
  Image normal;        // 3, tangent space, signed unit vectors, MikkTSpace, +Y up; empty: flat
  Image roughness;     // 1
  Image specular;      // 1, S: F0 = srgb_to_linear(S)
  Image sss;           // 1
  Image displacement;  // 1, cm from the plane z = 0 in the rest pose, positive towards +Z
  Image valid;         // 1, 1 where a face covers the texel, 0.5 where padding filled it, 0 elsewhere
};

struct ModelTriangle {
  uint32_t position[3];
  uint32_t uv[3];
  uint16_t set;            // index into Model::sets
  uint8_t material_class;  // MaterialClass
  uint32_t source_face;    // face of the scan
};

/// Canonical frame: right-handed, Y up, facing +Z, soles at y = 0, bounding box centred at x = z = 0.
/// Positions are shared across UV seams, so that smooth normals are too.
struct Model {
  std::string name;
  std::vector<Vec3f> positions_cm;
  std::vector<Vec2f> uvs;
  std::vector<ModelTriangle> triangles;
  std::vector<TextureSet> sets;
  std::string source_sha256;  // of the scan's mesh file
  std::string source_file;    // its name, without folders
  double source_unit_cm = 1;  // position_cm = source position x source_unit_cm + source_shift_cm
  Vec3f source_shift_cm;      // source position: after the turn that --up asked for
  std::string source_up;      // as turn_up (scan_unit.h); empty: none
  /// Unit, one a position, for shading instead of smooth_normals; empty: those. Only for meshes made in
  /// memory: a stored model has none. build_scene throws std::logic_error if their number is wrong.
  std::vector<Vec3f> normals;
};

/// MODEL on disk: model.xml (conventions, sets, sources), mesh.obj with mesh.mtl, faces.bin (class and source
/// face), maps/<set>/{albedo,alpha,normal,roughness,specular,sss,displacement}.exr, valid.png and small PNGs
/// to look at in maps/<set>/previews. Displacement is float, the others half. A set without a normal map
/// gets a flat normal.exr that model.xml does not list, so that it is not sampled.
/// Writes into `folder`, which is made if need be: give it an AtomicFolder's path. Throws InputError if it
/// cannot be written, TryAgainError if the disk is full, std::logic_error for an inconsistent model or one
/// with normals of its own.
void write_model(const std::filesystem::path& folder, const Model& model);

/// What of a model is read.
enum class ModelParts {
  kAll,
  kForRendering  // without displacement and validity maps, which no picture is made of: they stay empty
};

/// Throws InputError for a missing, incomplete or inconsistent folder. NaN and infinite texels are an error.
/// Mesh and maps are read in parallel.
Model read_model(const std::filesystem::path& folder, ModelParts parts = ModelParts::kAll);

/// Smooth normals: for each position the sum of the unit normals of its triangles weighted by the corner
/// angle, normalised (as Blender does); (0,0,1) where nothing remains. Same length as positions_cm.
std::vector<Vec3f> smooth_normals(const Model& model);

/// Lowest and highest corner of the bounding box, in the unit of the positions; all 0 if there are none.
struct Bounds {
  Vec3f low, high;
};
Bounds bounds_of(const std::vector<Vec3f>& positions);

}  // namespace ohb
