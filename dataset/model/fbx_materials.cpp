#include "dataset/model/fbx_materials.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "dataset/model/fbx_transform.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

/// Exporters name the slot in their own ways: the last part of "3dsMax|Parameters|base_color_map" counts.
std::string slot_of(const std::string& property) {
  const size_t bar = property.rfind('|');
  return property.substr(bar == std::string::npos ? 0 : bar + 1);
}

bool is_one_of(const std::string& slot, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return slot == name; });
}

}  // namespace

size_t FbxMaterials::index_of(const FbxNode* material, const FbxNode* mesh_texture) {
  const auto [at, is_new] = materials_.emplace(std::pair(material, mesh_texture), scan_.materials.size());
  if (!is_new) return at->second;
  if (scan_.materials.size() >= kMaxScanNames)
    scene_.file().fail("Objects", "has too many materials", "join some of them");
  ScanMaterial read;
  read.name = "default";
  if (material) read = read_material(*material);
  if (mesh_texture && read.diffuse.empty()) {
    set_picture(read, "DiffuseColor", *mesh_texture);
    const bool is_taken = std::any_of(scan_.materials.begin(), scan_.materials.end(),
                                      [&](const ScanMaterial& other) { return other.name == read.name; });
    if (!material) read.name = scene_.name_of(*mesh_texture);
    if (material && is_taken) read.name += "." + scene_.name_of(*mesh_texture);
  }
  if (!read.diffuse.empty()) {
    read.diffuse_factor = {1, 1, 1};  // Blender links the picture in the colour's place
    if (read.alpha.empty() && probe_image(read.diffuse).has_alpha) read.alpha = read.diffuse;
  }
  scan_.materials.push_back(std::move(read));
  return at->second;
}

ScanMaterial FbxMaterials::read_material(const FbxNode& node) {
  ScanMaterial material;
  material.name = scene_.name_of(node);
  const FbxProperties properties(scene_.file(), node, scene_.defaults_of("Material", "FbxSurfacePhong"));
  const auto colour = properties.vector("DiffuseColor", {1, 1, 1});
  for (double value : colour)
    if (!(value >= 0 && value < 1e6))
      scene_.file().fail("material '" + material.name + "'", "has no colour", "correct it");
  material.diffuse_factor = {static_cast<float>(colour[0]), static_cast<float>(colour[1]),
                             static_cast<float>(colour[2])};
  material.opacity = opacity_of(node, material.name);
  for (const FbxLink& link : scene_.parts_of(scene_.id_of(node)))
    if (const FbxNode* texture = scene_.object_of(link.other, "Texture"))
      set_picture(material, link.property.empty() ? "DiffuseColor" : link.property, *texture);
  // Where a picture states the opacity, Blender links it in the number's place; 0 with a picture is no number
  // that its author meant.
  const bool has_mask = !material.alpha.empty();
  if (has_mask ||
      (material.opacity == 0 && !material.diffuse.empty() && probe_image(material.diffuse).has_alpha))
    material.opacity = 1;
  if (material.opacity < 1) {
    char text[64];
    std::snprintf(text, sizeof text, "' has an opacity of %.4g", material.opacity);
    scan_.notes.push_back("material '" + material.name + text +
                          (material.opacity == 0 ? ": it is not seen, in Blender neither" : ""));
  }
  return material;
}

/// Blender's rule, which is Unity's: exporters fill TransparencyFactor, Opacity and TransparentColor in
/// contradictory ways.
float FbxMaterials::opacity_of(const FbxNode& node, const std::string& name) {
  const FbxProperties own(scene_.file(), node);
  const FbxProperties properties(scene_.file(), node, scene_.defaults_of("Material", "FbxSurfacePhong"));
  double opacity = 1 - properties.number("TransparencyFactor", 0);
  if (opacity == 1 || opacity == 0)
    opacity = own.number("Opacity", 1 - properties.vector("TransparentColor", {0, 0, 0})[0]);
  if (!(opacity >= -1e-6 && opacity <= 1 + 1e-6))
    scan_.notes.push_back("material '" + name + "': its opacity is not from 0 to 1; it is cut to that");
  return std::isfinite(opacity) ? static_cast<float>(std::clamp(opacity, 0.0, 1.0)) : 1;
}

void FbxMaterials::set_picture(ScanMaterial& material, const std::string& property, const FbxNode& texture) {
  const std::string slot = slot_of(property);
  if (is_one_of(slot, {"DiffuseColor", "base_color_map", "baseColor", "TEX_color_map", "diffuse_map",
                       "texmap_diffuse"})) {
    material.diffuse = picture_of(texture);
  } else if (is_one_of(slot, {"NormalMap", "normal_map", "norm_map", "normalCamera", "TEX_normal_map"})) {
    material.normal = picture_of(texture);
  } else if (is_one_of(slot, {"TransparentColor", "TransparencyFactor", "TransparentFactor", "Opacity",
                              "opacity_map", "cutout_map"})) {
    material.alpha = picture_of(texture);
  } else if (is_one_of(slot, {"Bump", "texmap_bump"})) {
    const ScanPicture picture = picture_of(texture);
    if (picture.empty()) return;
    if (!is_normal_map(picture)) {
      scan_.notes.push_back(picture.file.filename().string() + " is a grey height map, which is not used");
    } else if (material.normal.empty()) {
      material.normal = picture;
    }
  }
}

ScanPicture FbxMaterials::picture_of(const FbxNode& texture) {
  const auto known = pictures_.find(&texture);
  if (known != pictures_.end()) return known->second;
  const std::string place = "texture '" + scene_.name_of(texture) + "'";
  ScanPicture picture = find_picture(texture, place);
  if (!picture.empty()) picture.view = view_of(texture, place);
  return pictures_[&texture] = picture;
}

/// FBX keeps the paths of the machine that wrote it, in the texture and in its video.
ScanPicture FbxMaterials::find_picture(const FbxNode& texture, const std::string& place) {
  const FbxFile& file = scene_.file();
  std::vector<std::string> names;
  const auto add_names = [&](const FbxNode& node) {
    for (const char* key : {"RelativeFilename", "FileName", "Filename"}) {
      const FbxNode* name = node.child(key);
      if (name && !name->values.empty() && !file.text(*name, 0).empty()) names.push_back(file.text(*name, 0));
    }
  };
  add_names(texture);
  for (const FbxLink& link : scene_.parts_of(scene_.id_of(texture))) {
    const FbxNode* video = scene_.object_of(link.other, "Video");
    if (!video) continue;
    const FbxNode* content = video->child("Content");
    std::string bytes = content ? file.embedded_bytes(*content) : "";
    if (!bytes.empty()) return embed_picture(file.path(), scene_.name_of(*video), std::move(bytes));
    add_names(*video);
  }
  if (!names.empty()) return files_.picture(file.path(), place, names);
  scan_.notes.push_back(place + " names no picture");
  return {};
}

/// Blender: UV' = Scaling * R(Rotation) * (UV - Translation). Degrees; Blender's own files hold radians.
PictureView FbxMaterials::view_of(const FbxNode& texture, const std::string& place) const {
  const FbxFile& file = scene_.file();
  const FbxProperties properties(file, texture);
  const auto pair_of = [&](const char* child, double missing) {
    const FbxNode* node = texture.child(child);
    return node && node->values.size() > 1
               ? std::array<double, 3>{file.number(*node, 0), file.number(*node, 1), missing}
               : std::array<double, 3>{missing, missing, missing};
  };
  const auto moved = properties.vector("Translation", pair_of("ModelUVTranslation", 0));
  auto scale = properties.vector("Scaling", pair_of("ModelUVScaling", 1));
  for (double& s : scale)
    if (s == 0) s = 1;
  const FbxNode* header = file.root().child("FBXHeaderExtension");
  const FbxNode* creator = header ? header->child("Creator") : nullptr;
  const bool is_blender =
      creator && !creator->values.empty() && file.text(*creator, 0).find("Blender") != std::string::npos;
  const double turned = properties.vector("Rotation", {0, 0, 0})[2] * (is_blender ? 1 : M_PI / 180);
  const double c = std::cos(turned), s = std::sin(turned);
  PictureView view;
  view.uu = scale[0] * c;
  view.uv = -scale[0] * s;
  view.vu = scale[1] * s;
  view.vv = scale[1] * c;
  view.u0 = -view.uu * moved[0] - view.uv * moved[1];
  view.v0 = -view.vu * moved[0] - view.vv * moved[1];
  for (double number : {view.uu, view.uv, view.u0, view.vu, view.vv, view.v0})
    if (!std::isfinite(number)) file.fail(place, "has a transform that is not finite", "correct it");
  if (properties.number("WrapModeU", 0) == 1) view.wrap_u = Wrap::kClamp;
  if (properties.number("WrapModeV", 0) == 1) view.wrap_v = Wrap::kClamp;
  return view;
}

}  // namespace ohb
