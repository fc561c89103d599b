#include "dataset/model/gltf_materials.h"

#include <algorithm>
#include <cmath>

#include "dataset/model/gltf_nodes.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

using nlohmann::json;

constexpr const char* kSpecGloss = "KHR_materials_pbrSpecularGlossiness";

/// `object.extensions[name]`, null if it is not there.
const json* extension(const json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return nullptr;
  const auto found = extensions->find(name);
  return found == extensions->end() ? nullptr : &*found;
}

Wrap wrap_of(const json& sampler, const char* key) {
  constexpr size_t kRepeats = 10497, kClampsToEdge = 33071, kMirrors = 33648;
  switch (index_or(sampler, key, kRepeats)) {
    case kClampsToEdge:
      return Wrap::kClamp;
    case kMirrors:
      return Wrap::kMirror;
    default:
      return Wrap::kRepeat;
  }
}

size_t uv_set_of(const json& info) {
  const json* const transform = extension(info, "KHR_texture_transform");
  return index_or(transform && transform->contains("texCoord") ? *transform : info, "texCoord", 0);
}

}  // namespace

ScanMaterial GltfMaterials::read(size_t index) {
  const json& from = gltf_.item("materials", index);
  const std::string place = gltf_place("materials", index);
  ScanMaterial material;
  uv_set_ = kMissing;
  material.name = from.value("name", "material" + std::to_string(index));
  read_colour(from, place, material);
  read_normal(from, place, material);
  note_unused(from);
  if (uv_set_ == kMissing) uv_set_ = 0;
  return material;
}

void GltfMaterials::read_colour(const json& from, const std::string& place, ScanMaterial& material) {
  const json* const spec_gloss = extension(from, kSpecGloss);
  const json surface = spec_gloss ? *spec_gloss : from.value("pbrMetallicRoughness", json::object());
  const auto factor = numbers_or<4>(surface, spec_gloss ? "diffuseFactor" : "baseColorFactor", {1, 1, 1, 1});
  for (double value : factor)
    if (!(value >= 0 && value < 1e6))
      gltf_.fail(place, "has a colour factor that is no colour", "correct it");
  material.diffuse_factor = {static_cast<float>(factor[0]), static_cast<float>(factor[1]),
                             static_cast<float>(factor[2])};
  const char* const texture = spec_gloss ? "diffuseTexture" : "baseColorTexture";
  if (surface.contains(texture)) {
    uv_set_ = uv_set_of(surface.at(texture));
    material.diffuse = read_texture(surface.at(texture), place);
  }
  if (spec_gloss)
    notes_.push_back(place + ": " + kSpecGloss +
                     ": its diffuse colour is used, glossiness and specular are not");
  else if (!surface.contains(texture) && from.contains("emissiveTexture"))
    notes_.push_back(place + ": has an emissive picture alone, which is not used");
  read_opacity(from, place, factor[3], material);
}

void GltfMaterials::read_opacity(const json& from, const std::string& place, double alpha,
                                 ScanMaterial& material) {
  const std::string mode = from.value("alphaMode", "OPAQUE");
  ignores_alpha_ = mode != "MASK" && mode != "BLEND";
  if (ignores_alpha_) return;
  material.opacity = static_cast<float>(std::min(alpha, 1.0));
  if (!material.diffuse.empty() && probe_image(material.diffuse).has_alpha) material.alpha = material.diffuse;
  if (mode != "MASK") return;
  const double cutoff = from.value("alphaCutoff", 0.5);
  if (!(cutoff >= 0 && cutoff < 1e6)) gltf_.fail(place, "has an alphaCutoff that is none", "correct it");
  material.alpha_cutoff = static_cast<float>(cutoff);
}

void GltfMaterials::read_normal(const json& from, const std::string& place, ScanMaterial& material) {
  if (!from.contains("normalTexture")) return;
  const json& info = from.at("normalTexture");
  if (uv_set_ != kMissing && uv_set_of(info) != uv_set_) {
    notes_.push_back(place + ": its normal map has other UVs than its colour and is not used");
    return;
  }
  uv_set_ = uv_set_of(info);
  material.normal = read_texture(info, place);
  if (info.value("scale", 1.0) != 1.0) notes_.push_back(place + ": the normal map's scale is not used");
}

void GltfMaterials::note_unused(const json& from) {
  const auto extensions = from.find("extensions");
  if (extensions == from.end()) return;
  for (const auto& [name, value] : extensions->items())
    if (name != kSpecGloss && name != "KHR_materials_unlit") unused_.insert(name);
}

std::vector<std::string> GltfMaterials::notes() const {
  std::vector<std::string> notes = notes_;
  if (unused_.empty()) return notes;
  std::string names;
  for (const std::string& name : unused_) names += (names.empty() ? "" : ", ") + name;
  notes.push_back("the materials' " + names + (unused_.size() == 1 ? " is" : " are") + " not used");
  return notes;
}

ScanPicture GltfMaterials::read_texture(const json& info, const std::string& place) {
  const json& texture = gltf_.item("textures", index_or(info, "index"));
  const size_t image = image_of(texture, place);
  if (image == kMissing) return {};
  ScanPicture picture = read_picture(image);
  picture.view = view_of(info, texture);
  return picture;
}

/// PNG and JPEG before WebP: where a file has both, the first is what all programs show. kMissing: none is
/// read.
size_t GltfMaterials::image_of(const json& texture, const std::string& place) {
  size_t source = index_or(texture, "source");
  if (source != kMissing) return source;
  const json* const webp = extension(texture, "EXT_texture_webp");
  if (webp) source = index_or(*webp, "source");
  if (source != kMissing) return source;
  std::string names;
  if (texture.contains("extensions"))
    for (const auto& [name, value] : texture.at("extensions").items())
      names += (names.empty() ? "" : ", ") + name;
  files_.add_missing(gltf_.path(), place,
                     names.empty() ? "has a texture without a picture"
                                   : "has a picture of " + names + " alone, which is not read",
                     "export PNG or JPEG pictures");
  return kMissing;
}

/// KHR_texture_transform: glTF's (v down) is translation x rotation x scale; ours has v up.
PictureView GltfMaterials::view_of(const json& info, const json& texture) const {
  PictureView view;
  const size_t sampler = index_or(texture, "sampler");
  if (sampler != kMissing) {
    view.wrap_u = wrap_of(gltf_.item("samplers", sampler), "wrapS");
    view.wrap_v = wrap_of(gltf_.item("samplers", sampler), "wrapT");
  }
  const json* const transform = extension(info, "KHR_texture_transform");
  if (!transform) return view;
  const auto offset = numbers_or<2>(*transform, "offset", {0, 0});
  const auto scale = numbers_or<2>(*transform, "scale", {1, 1});
  const double rotation = transform->value("rotation", 0.0);
  const double c = std::cos(rotation), s = std::sin(rotation);
  view.uu = c * scale[0];
  view.uv = -s * scale[1];
  view.u0 = offset[0] + s * scale[1];
  view.vu = s * scale[0];
  view.vv = c * scale[1];
  view.v0 = 1 - offset[1] - c * scale[1];
  return view;
}

ScanPicture GltfMaterials::read_picture(size_t index) {
  const auto known = pictures_.find(index);
  if (known != pictures_.end()) return known->second;
  const json& image = gltf_.item("images", index);
  const std::string place = gltf_place("images", index);
  const std::string label = "image" + std::to_string(index);
  ScanPicture picture;
  if (image.contains("uri")) {
    const std::string uri = image.at("uri").get<std::string>();
    std::string bytes;
    picture = gltf_.decode_data_uri(uri, place, bytes)
                  ? embed_picture(gltf_.path(), label, std::move(bytes))
                  : files_.picture(gltf_.path(), place, {decode_percent(uri)});
  } else {
    picture =
        embed_picture(gltf_.path(), label, std::string(gltf_.buffer_view(index_or(image, "bufferView"))));
  }
  return pictures_[index] = picture;
}

}  // namespace ohb
