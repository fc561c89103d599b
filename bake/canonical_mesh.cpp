#include "bake/canonical_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "bake/repeated_faces.h"
#include "dataset/model/error.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::bake {
namespace {

InputError face_error(const Scan& scan, size_t face, const std::string& cause, const std::string& mend) {
  return InputError(scan.file.string(), "face " + std::to_string(face), cause, mend);
}

void check_labels(const Scan& scan, const Regions& regions) {
  if (regions.face_class.size() != scan.face_count())
    throw InputError(scan.file.string(), "",
                     "has " + std::to_string(scan.face_count()) + " faces, the regions have " +
                         std::to_string(regions.face_class.size()),
                     "label this scan");
  size_t unlabelled = 0, first = 0;
  for (size_t f = regions.face_class.size(); f-- > 0;)
    if (regions.face_class[f] >= kClassCount) {
      ++unlabelled;
      first = f;
    }
  if (unlabelled > 0)
    throw face_error(scan, first,
                     "has no class (so have " + std::to_string(unlabelled) + " of " +
                         std::to_string(regions.face_class.size()) + " faces)",
                     "label every face: give `label` rules with a default class, or --faces");
}

void check_uvs(const Scan& scan, const ScanTriangle& triangle) {
  for (int c = 0; c < 3; ++c) {
    const Corner& corner = scan.corners[triangle.corner[c]];
    if (corner.uv == Corner::kNoUv)
      throw face_error(scan, triangle.face, "has no UV coordinates",
                       "unwrap the mesh first: maps are baked into its UV layout");
    const Vec2f a = scan.uvs[corner.uv];
    if (!(std::abs(a.x) <= surface::kMaxUv && std::abs(a.y) <= surface::kMaxUv))
      throw face_error(scan, triangle.face,
                       "has a UV coordinate beyond " + std::to_string(int(surface::kMaxUv)),
                       "divide UVs in pixels by the size of the picture");
  }
  for (int c = 0; c < 3; ++c) {
    const Vec2f a = scan.uvs[scan.corners[triangle.corner[c]].uv];
    const Vec2f b = scan.uvs[scan.corners[triangle.corner[(c + 1) % 3]].uv];
    if (!(std::abs(a.x - b.x) <= surface::kMaxUvSpan && std::abs(a.y - b.y) <= surface::kMaxUvSpan))
      throw face_error(
          scan, triangle.face,
          "spans more than " + std::to_string(int(surface::kMaxUvSpan)) + " repetitions of its picture",
          "correct the UVs of this face");
  }
}

/// Gives each used index of the scan its place among the used ones, in the order of the scan.
struct Compaction {
  static constexpr uint32_t kUnused = 0xffffffffu;
  std::vector<uint32_t> place;
  explicit Compaction(size_t count) : place(count, kUnused) {}
  void use(uint32_t index) { place[index] = 0; }
  template <typename Value>
  std::vector<Value> apply(const std::vector<Value>& values) {
    std::vector<Value> used;
    for (size_t i = 0; i < values.size(); ++i) {
      if (place[i] == kUnused) continue;
      place[i] = static_cast<uint32_t>(used.size());
      used.push_back(values[i]);
    }
    return used;
  }
};

void place_in_world(Model& model, double unit_cm) {
  const Bounds bounds = bounds_of(model.positions_cm);
  const auto middle = [](float low, float high) { return (static_cast<double>(low) + high) / 2; };
  model.source_unit_cm = unit_cm;
  const auto opposite = [&](double position) { return static_cast<float>(0 - unit_cm * position); };
  model.source_shift_cm = {opposite(middle(bounds.low.x, bounds.high.x)), opposite(bounds.low.y),
                           opposite(middle(bounds.low.z, bounds.high.z))};
  const Vec3f shift = model.source_shift_cm;
  for (Vec3f& p : model.positions_cm)
    p = {static_cast<float>(p.x * unit_cm + shift.x), static_cast<float>(p.y * unit_cm + shift.y),
         static_cast<float>(p.z * unit_cm + shift.z)};
}

/// The texture sets of the materials that have faces; gives the set of each material.
std::vector<uint16_t> make_sets(const Scan& scan, CanonicalMesh& mesh) {
  std::vector<bool> has_faces(scan.materials.size(), false);
  for (uint16_t material : scan.face_material) has_faces[material] = true;
  std::vector<uint16_t> set_of_material(scan.materials.size(), 0);
  for (size_t m = 0; m < scan.materials.size(); ++m) {
    if (!has_faces[m]) continue;
    set_of_material[m] = static_cast<uint16_t>(mesh.model.sets.size());
    mesh.material_of_set.push_back(static_cast<uint16_t>(m));
    mesh.model.sets.emplace_back();
    mesh.model.sets.back().name = scan.materials[m].name;
  }
  return set_of_material;
}

/// The scan's triangles without those of repeated faces.
void keep_triangles_once(const Scan& scan, CanonicalMesh& mesh) {
  const std::vector<bool> repeated = repeated_faces(scan);
  mesh.repeated_faces = static_cast<size_t>(std::count(repeated.begin(), repeated.end(), true));
  std::vector<ScanTriangle>& triangles = mesh.triangles = triangulate(scan);
  triangles.erase(std::remove_if(triangles.begin(), triangles.end(),
                                 [&](const ScanTriangle& triangle) { return repeated[triangle.face]; }),
                  triangles.end());
}

}  // namespace

CanonicalMesh canonical_mesh(const Scan& scan, const Regions& regions, double unit_cm) {
  check_labels(scan, regions);
  CanonicalMesh mesh;
  const std::vector<uint16_t> set_of_material = make_sets(scan, mesh);
  keep_triangles_once(scan, mesh);
  const std::vector<ScanTriangle>& triangles = mesh.triangles;
  Compaction positions(scan.positions.size()), uvs(scan.uvs.size());
  for (const ScanTriangle& triangle : triangles) {
    check_uvs(scan, triangle);
    for (uint32_t corner : triangle.corner) {
      positions.use(scan.corners[corner].position);
      uvs.use(scan.corners[corner].uv);
    }
  }
  mesh.model.positions_cm = positions.apply(scan.positions);
  mesh.model.uvs = uvs.apply(scan.uvs);
  mesh.model.source_up = regions.up;
  place_in_world(mesh.model, unit_cm);
  mesh.model.source_file = scan.file.filename().string();
  mesh.model.source_sha256 = regions.scan_sha256;

  double area = 0;
  for (const ScanTriangle& triangle : triangles) {
    ModelTriangle out{};
    for (int c = 0; c < 3; ++c) {
      out.position[c] = positions.place[scan.corners[triangle.corner[c]].position];
      out.uv[c] = uvs.place[scan.corners[triangle.corner[c]].uv];
    }
    out.set = set_of_material[scan.face_material[triangle.face]];
    out.material_class = regions.face_class[triangle.face];
    out.source_face = triangle.face;
    mesh.model.triangles.push_back(out);
    area += area_cm2(mesh.model, out);
  }
  if (!(area > 0)) throw InputError(scan.file.string(), "", "no face has an area", "export the mesh again");
  return mesh;
}

double area_cm2(const Model& model, const ModelTriangle& triangle) {
  const Vec3f a = model.positions_cm[triangle.position[0]];
  const Vec3f b = model.positions_cm[triangle.position[1]], c = model.positions_cm[triangle.position[2]];
  const double u[3] = {double(b.x) - a.x, double(b.y) - a.y, double(b.z) - a.z};
  const double v[3] = {double(c.x) - a.x, double(c.y) - a.y, double(c.z) - a.z};
  const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
  return std::sqrt(x * x + y * y + z * z) / 2;
}

}  // namespace ohb::bake
