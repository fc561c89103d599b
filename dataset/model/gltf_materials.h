// The materials of a glTF file: pictures with their transforms and wrapping, factors, opacity.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "dataset/model/gltf_file.h"
#include "dataset/model/scan_files.h"

namespace ohb {

class GltfMaterials {
 public:
  /// Both must outlive this; pictures that are not there are reported to `files`.
  GltfMaterials(const GltfFile& gltf, ScanFiles& files) : gltf_(gltf), files_(files) {}

  /// Reads one; its pictures' UVs are of set uv_set. Throws InputError.
  ScanMaterial read(size_t index);
  /// The number of the TEXCOORD that the pictures of the material read last use.
  size_t uv_set() const { return uv_set_; }
  /// Whether the material read last has alphaMode OPAQUE, to which no alpha matters.
  bool ignores_alpha() const { return ignores_alpha_; }
  /// What was seen and not used, once all are read.
  std::vector<std::string> notes() const;

 private:
  ScanPicture read_texture(const nlohmann::json& info, const std::string& place);
  ScanPicture read_picture(size_t image);
  size_t image_of(const nlohmann::json& texture, const std::string& place);
  PictureView view_of(const nlohmann::json& info, const nlohmann::json& texture) const;
  void read_colour(const nlohmann::json& from, const std::string& place, ScanMaterial& material);
  void read_normal(const nlohmann::json& from, const std::string& place, ScanMaterial& material);
  void read_opacity(const nlohmann::json& from, const std::string& place, double alpha,
                    ScanMaterial& material);
  void note_unused(const nlohmann::json& from);

  const GltfFile& gltf_;
  ScanFiles& files_;
  std::map<size_t, ScanPicture> pictures_;
  std::vector<std::string> notes_;
  std::set<std::string> unused_;  // extensions of materials
  size_t uv_set_ = 0;
  bool ignores_alpha_ = true;
};

}  // namespace ohb
