#include "dataset/model/fbx_shapes.h"

#include <algorithm>
#include <cstdio>

#include "dataset/model/fbx_transform.h"

namespace ohb {
namespace {

constexpr const char* kExportAgain = "export the scan again";

struct Shape {
  std::string name;
  const FbxNode* offsets = nullptr;  // Indexes and Vertices
  double weight = 0;                 // 1: fully
  std::vector<double> full_weights;  // of each index; empty: 1
};

/// Blender 3.4 reads the channel's own DeformPercent, 100 if there is none, and keys go from 0 to 1.
double weight_of(const FbxScene& scene, const FbxNode& channel) {
  const FbxNode* stated = channel.child("DeformPercent");
  const double percent = stated && !stated->values.empty()
                             ? scene.file().number(*stated, 0)
                             : FbxProperties(scene.file(), channel).number("DeformPercent", 100);
  return percent > 0 ? std::min(percent / 100, 1.0) : 0;
}

std::vector<Shape> shapes_of_version_7(const FbxScene& scene, const FbxNode& geometry) {
  std::vector<Shape> shapes;
  for (const FbxLink& deformer : scene.parts_of(scene.id_of(geometry))) {
    const FbxNode* blend = scene.object_of(deformer.other, "Deformer");
    if (!blend || scene.type_of(*blend) != "BlendShape") continue;
    for (const FbxLink& part : scene.parts_of(deformer.other)) {
      const FbxNode* channel = scene.object_of(part.other, "Deformer");
      if (!channel || scene.type_of(*channel) != "BlendShapeChannel") continue;
      Shape shape{scene.name_of(*channel), nullptr, weight_of(scene, *channel), {}};
      if (const FbxNode* full = channel->child("FullWeights"))
        shape.full_weights = scene.file().numbers(*full);
      for (const FbxLink& target : scene.parts_of(part.other)) {
        shape.offsets = scene.object_of(target.other, "Geometry");
        if (shape.offsets) shapes.push_back(shape);
      }
    }
  }
  return shapes;
}

/// Version 6 keeps them in the mesh; the weight is the mesh's property of that name.
std::vector<Shape> shapes_of_version_6(const FbxScene& scene, const FbxNode& mesh) {
  std::vector<Shape> shapes;
  for (const FbxNode& node : mesh.children) {
    if (node.name != "Shape" || node.values.empty()) continue;
    const std::string name = scene.file().text(node, 0);
    const double percent = FbxProperties(scene.file(), mesh).number(name, 0);
    shapes.push_back({name, &node, percent > 0 ? std::min(percent / 100, 1.0) : 0, {}});
  }
  return shapes;
}

void apply(const FbxFile& file, const Shape& shape, const std::string& place, std::vector<Vec3d>& positions) {
  const FbxNode *indexes = shape.offsets->child("Indexes"), *vertices = shape.offsets->child("Vertices");
  if (!indexes || !vertices || indexes->values.empty() || vertices->values.empty()) return;
  const std::vector<double> index = file.numbers(*indexes), offset = file.numbers(*vertices);
  const std::string key = place + ", shape key '" + shape.name + "'";
  if (offset.size() != 3 * index.size())
    file.fail(key,
              "has " + std::to_string(offset.size() / 3) + " offsets for " + std::to_string(index.size()) +
                  " vertices",
              kExportAgain);
  const std::vector<double>& full = shape.full_weights;
  for (size_t i = 0; i < index.size(); ++i) {
    if (!(index[i] >= 0 && index[i] < static_cast<double>(positions.size())))
      file.fail(key, "names a vertex that the mesh has not", kExportAgain);
    const double share = full.size() == index.size() ? full[i] / 100 : full.size() == 1 ? full[0] / 100 : 1;
    const double weight = shape.weight * std::clamp(share, 0.0, 1.0);
    Vec3d& p = positions[static_cast<size_t>(index[i])];
    p.x += weight * offset[3 * i];
    p.y += weight * offset[3 * i + 1];
    p.z += weight * offset[3 * i + 2];
  }
}

}  // namespace

void apply_fbx_shapes(const FbxScene& scene, const FbxNode& geometry, const std::string& place,
                      std::vector<Vec3d>& positions, std::vector<std::string>& notes) {
  const std::vector<Shape> shapes =
      scene.is_version_6() ? shapes_of_version_6(scene, geometry) : shapes_of_version_7(scene, geometry);
  std::string applied;
  size_t at_zero = 0;
  for (const Shape& shape : shapes) {
    if (shape.weight == 0) {
      ++at_zero;
      continue;
    }
    apply(scene.file(), shape, place, positions);
    char percent[32];
    std::snprintf(percent, sizeof percent, "%.4g %%", 100 * shape.weight);
    applied += (applied.empty() ? "'" : ", '") + shape.name + "' at " + percent;
  }
  if (!applied.empty())
    notes.push_back(place + ": shape keys applied: " + applied +
                    (at_zero ? "; " + std::to_string(at_zero) + " others are at 0" : ""));
}

}  // namespace ohb
