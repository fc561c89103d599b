// The parts of a MODEL folder, for writers that cannot hold all texture sets at once.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dataset/model/map_table.h"
#include "dataset/model/model.h"

namespace ohb {

/// One kind of map of a texture set.
struct MapKind {
  const char* name;  // file maps/<set>/<name>.exr and the part's name in it
  Image TextureSet::*image;
  int channels;
  bool is_float;     // float or half on disk
  bool is_optional;  // an empty image has a meaning
};

constexpr auto map_kinds() {
  std::array<MapKind, 4 + kMaterialMaps.size()> kinds{};
  size_t i = 0;
  kinds[i++] = {"albedo", &TextureSet::albedo, 3, false, false};
  kinds[i++] = {"alpha", &TextureSet::alpha, 1, false, true};
  kinds[i++] = {"normal", &TextureSet::normal, 3, false, true};
  for (const MaterialMap& map : kMaterialMaps) kinds[i++] = {map.name, map.texels, 1, false, false};
  kinds[i] = {"displacement", &TextureSet::displacement, 1, true, false};
  return kinds;
}

/// All maps that are EXR, in the order of model.xml.
constexpr auto kMapKinds = map_kinds();

/// What model.xml says about a set.
struct TextureSetEntry {
  std::string name;    // as in the scan
  std::string folder;  // maps/<folder>, and usemtl in mesh.obj
  int width_px = 0, height_px = 0;
  std::vector<std::string> maps;  // names of kMapKinds that are there
};

/// Folder names for sets of these names: portable characters only, unique even where case is ignored.
std::vector<std::string> texture_set_folders(const std::vector<std::string>& names);

/// One map of a set into maps/<entry.folder>/ of the MODEL at `folder`, with its preview; it must have the
/// entry's size. `mips`: as ExrPart::mips. An empty image: nothing, or a flat normal map. Gives whether
/// model.xml names the map.
bool write_texture_map(const std::filesystem::path& folder, const MapKind& kind, Image image,
                       const TextureSetEntry& entry, std::vector<Image> mips = {});

/// maps/<set_folder>/ of the MODEL at `folder`; each map's memory is freed once it is on disk.
/// Throws as write_model.
TextureSetEntry write_texture_set(const std::filesystem::path& folder, const std::string& set_folder,
                                  TextureSet&& set);

/// Everything but the maps; model.sets is not looked at, `sets` is.
void write_model_mesh(const std::filesystem::path& folder, const Model& model,
                      const std::vector<TextureSetEntry>& sets);

/// mesh.obj of a model: `v`, `vt`, and `f a/b ...` in triangle order with `usemtl <folder of the set>`.
/// Numbers are the shortest that read back exactly.
std::string mesh_obj_text(const Model& model, const std::vector<TextureSetEntry>& sets);

/// Fills positions_cm, uvs and triangles (class and source face 0) from the text that mesh_obj_text writes.
/// Throws InputError naming `file` and the line for anything else.
void parse_mesh_obj(const std::string& text, const std::filesystem::path& file,
                    const std::vector<TextureSetEntry>& sets, Model& model);

/// The first thing that is wrong with the mesh (no triangles, index out of range, NaN, unknown class), or "".
std::string mesh_fault(const Model& model, size_t set_count);

}  // namespace ohb
