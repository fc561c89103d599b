// Scans from meshes made in memory, and regions of one class.
#pragma once

#include <vector>

#include "dataset/model/model.h"
#include "dataset/model/regions.h"
#include "dataset/model/scan.h"
#include "tests/support/test_models.h"

namespace ohb {

inline Scan scan_of_model(const Model& model, const std::string& file) {
  Scan scan;
  scan.file = file;
  scan.positions = model.positions_cm;
  scan.uvs = model.uvs;
  scan.groups = {"all"};
  scan.face_begin = {0};
  for (const ModelTriangle& triangle : model.triangles) {
    for (int c = 0; c < 3; ++c) scan.corners.push_back({triangle.position[c], triangle.uv[c]});
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    scan.face_material.push_back(0);
    scan.face_group.push_back(0);
  }
  scan.materials.resize(1);
  scan.materials[0].name = "all";
  return scan;
}

inline Regions one_class(const Scan& scan, uint8_t material_class = kSkin) {
  return {std::vector<uint8_t>(scan.face_count(), material_class), std::string(64, '0')};
}

/// A grid over [0,edge]^2 at the height z(x, y), facing +Z, its UVs over [0,1]^2.
inline Model height_field(int cells, float edge_cm, const std::function<float(float x, float y)>& z) {
  return grid_model(
      cells, cells,
      [&](float u, float v) {
        return Vec3f{u * edge_cm, v * edge_cm, z(u * edge_cm, v * edge_cm)};
      },
      TextureSet());
}

}  // namespace ohb
