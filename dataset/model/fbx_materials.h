// Materials of FBX: colour, opacity and pictures with their transforms, as Blender 3.4 takes them.
#pragma once

#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>

#include "dataset/model/fbx_scene.h"
#include "dataset/model/scan.h"
#include "dataset/model/scan_files.h"

namespace ohb {

class FbxMaterials {
 public:
  /// Materials, notes and missing pictures go into `scan`; all must outlive this.
  FbxMaterials(const FbxScene& scene, Scan& scan, ScanFiles& files)
      : scene_(scene), scan_(scan), files_(files) {}

  /// Index in Scan::materials of the material (null: a grey default) with a picture that the mesh and not the
  /// material names (version 6; null: none). Throws InputError.
  size_t index_of(const FbxNode* material, const FbxNode* mesh_texture = nullptr);

 private:
  ScanMaterial read_material(const FbxNode& node);
  float opacity_of(const FbxNode& node, const std::string& name);
  void set_picture(ScanMaterial& material, const std::string& property, const FbxNode& texture);
  ScanPicture picture_of(const FbxNode& texture);
  ScanPicture find_picture(const FbxNode& texture, const std::string& place);
  PictureView view_of(const FbxNode& texture, const std::string& place) const;

  const FbxScene& scene_;
  Scan& scan_;
  ScanFiles& files_;
  std::map<std::pair<const FbxNode*, const FbxNode*>, size_t> materials_;
  std::unordered_map<const FbxNode*, ScanPicture> pictures_;
};

}  // namespace ohb
