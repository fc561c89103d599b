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

/// Both meshes in one.
inline Model joined(Model a, const Model& b) {
  const uint32_t positions = static_cast<uint32_t>(a.positions_cm.size());
  const uint32_t uvs = static_cast<uint32_t>(a.uvs.size());
  a.positions_cm.insert(a.positions_cm.end(), b.positions_cm.begin(), b.positions_cm.end());
  a.uvs.insert(a.uvs.end(), b.uvs.begin(), b.uvs.end());
  for (ModelTriangle triangle : b.triangles) {
    for (int c = 0; c < 3; ++c) {
      triangle.position[c] += positions;
      triangle.uv[c] += uvs;
    }
    a.triangles.push_back(triangle);
  }
  return a;
}

inline Model turned_over(Model model) {
  for (ModelTriangle& triangle : model.triangles) {
    std::swap(triangle.position[1], triangle.position[2]);
    std::swap(triangle.uv[1], triangle.uv[2]);
  }
  return model;
}

}  // namespace ohb
