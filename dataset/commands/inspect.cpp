#include "dataset/commands/inspect.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "dataset/commands/inspect_warnings.h"
#include "dataset/model/mesh_topology.h"
#include "dataset/surface/picture.h"

namespace ohb::commands {
namespace {

/// Faces with less area than the square of this share of the diagonal have none.
constexpr double kZeroLength = 1e-6;
constexpr double kSmallComponent = 1e-3;
constexpr float kOpaque = 0.999f;
constexpr double kShortestPerson_cm = 80;  // children too; a bust has no feet

double area_of(const Scan& scan, const ScanTriangle& triangle) {
  double p[3][3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) p[i][k] = scan.positions[scan.corners[triangle.corner[i]].position][k];
  double a[3], b[3];
  for (int k = 0; k < 3; ++k) {
    a[k] = p[1][k] - p[0][k];
    b[k] = p[2][k] - p[0][k];
  }
  return 0.5 * std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

void count_elements(const Scan& scan, const std::vector<ScanTriangle>& triangles, InspectReport& report) {
  report.vertices = scan.positions.size();
  report.uvs = scan.uvs.size();
  report.faces = scan.face_count();
  report.triangles = triangles.size();
  for (size_t f = 0; f < scan.face_count(); ++f) {
    const uint32_t corners = scan.face_begin[f + 1] - scan.face_begin[f];
    ++(corners == 3 ? report.triangle_faces : corners == 4 ? report.quad_faces : report.larger_faces);
  }
}

void count_bad_faces(const Scan& scan, const MeshTopology& topology, const std::vector<double>& face_area,
                     InspectReport& report) {
  const Bounds& b = report.bounds;
  const double diagonal =
      std::hypot(static_cast<double>(b.high.x) - b.low.x, static_cast<double>(b.high.y) - b.low.y,
                 static_cast<double>(b.high.z) - b.low.z);
  std::vector<std::vector<uint32_t>> faces(scan.face_count());
  for (size_t f = 0; f < faces.size(); ++f) {
    for (uint32_t c = scan.face_begin[f]; c < scan.face_begin[f + 1]; ++c)
      faces[f].push_back(topology.point_of_position[scan.corners[c].position]);
    std::sort(faces[f].begin(), faces[f].end());
    report.repeated_vertex_faces += std::adjacent_find(faces[f].begin(), faces[f].end()) != faces[f].end();
    report.zero_area_faces += face_area[f] <= kZeroLength * kZeroLength * diagonal * diagonal;
  }
  std::sort(faces.begin(), faces.end());
  for (size_t f = 1; f < faces.size(); ++f) report.duplicate_faces += faces[f] == faces[f - 1];
}

void count_edges(const MeshTopology& topology, InspectReport& report) {
  DisjointSets loops(topology.point_count);
  std::vector<bool> on_border(topology.point_count, false);
  for (const MeshEdge& edge : topology.edges) {
    if (edge.use_count == 1) {
      ++report.border_edges;
      loops.join(edge.point[0], edge.point[1]);
      on_border[edge.point[0]] = on_border[edge.point[1]] = true;
    } else if (edge.use_count > 2) {
      ++report.non_manifold_edges;
    } else if (topology.uses[edge.first_use].forward == topology.uses[edge.first_use + 1].forward) {
      ++report.inconsistent_edges;
    }
  }
  for (uint32_t p = 0; p < topology.point_count; ++p) report.holes += on_border[p] && loops.find(p) == p;
  report.points = topology.point_count;
  for (uint32_t point : topology.point_of_position) report.unused_vertices += point == MeshTopology::kNoPoint;
}

void count_components(const MeshTopology& topology, const std::vector<double>& face_area,
                      InspectReport& report) {
  std::vector<double> area(topology.component_count, 0);
  double total = 0;
  for (size_t f = 0; f < face_area.size(); ++f) {
    area[topology.component_of_face[f]] += face_area[f];
    total += face_area[f];
  }
  report.components = topology.component_count;
  for (double a : area) report.small_components += a < kSmallComponent * total;
}

/// Share of the texels under the material's faces whose opacity is below 1; of the picture alone where the
/// material does not use its alpha. `channel`: the one that says it.
double transparent_share(const Image& image, int channel, const UvRaster& raster, int raster_width,
                         int raster_height, const ScanMaterial& material) {
  size_t transparent = 0;
  if (raster.face.empty() || raster.covered == 0) return 0;
  for (int y = 0; y < raster_height; ++y)
    for (int x = 0; x < raster_width; ++x) {
      if (raster.face[static_cast<size_t>(y) * raster_width + x] == kNoFace) continue;
      const auto column = static_cast<int>((x + 0.5) * image.width_px / raster_width),
                 row = static_cast<int>((y + 0.5) * image.height_px / raster_height);
      const float alpha = image.pixel(column, row)[channel];
      transparent += (material.alpha.empty() ? alpha : material.opacity_of(alpha)) < kOpaque;
    }
  return static_cast<double>(transparent) / static_cast<double>(raster.covered);
}

/// Together the materials take no more than this; a grid of 2048 squared takes some milliseconds to clear.
UvGrid grid_for(const std::vector<MaterialFaces>& materials) {
  constexpr double kAllTests = 5e8, kAllTexels = 1 << 29;
  const auto used = static_cast<double>(std::count_if(
      materials.begin(), materials.end(), [](const MaterialFaces& m) { return !m.faces.empty(); }));
  UvGrid grid;
  grid.max_tests = std::min(grid.max_tests, kAllTests / std::max(1.0, used));
  while (used * grid.size_px * grid.size_px > kAllTexels) grid.size_px /= 2;
  return grid;
}

class MaterialInspector {
 public:
  MaterialInspector(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                    const MeshTopology& topology)
      : scan_(scan),
        topology_(topology),
        materials_(faces_of_materials(scan, triangles)),
        grid_(grid_for(materials_)),
        chart_of_face_(uv_charts(scan)) {}

  MaterialReport inspect(uint16_t material) {
    const ScanMaterial& from = scan_.materials[material];
    MaterialReport report;
    report.name = from.name;
    report.opacity = from.opacity;
    report.alpha_cutoff = from.alpha_cutoff;
    report.has_vertex_colours = from.has_vertex_colours;
    report.uv = measure_uv_layout(scan_, materials_[material], topology_, grid_);
    for (const auto& [use, picture] : {std::pair<const char*, const ScanPicture&>("diffuse", from.diffuse),
                                       {"alpha", from.alpha},
                                       {"normal", from.normal}}) {
      if (picture.empty()) continue;
      const bool is_seen = std::string(use) == "alpha" && picture.file == from.diffuse.file &&
                           report.pictures.front().is_cut_out;
      report.pictures.push_back(is_seen ? report.pictures.front() : inspect_picture(material, use, picture));
      report.pictures.back().use = use;
    }
    return report;
  }

 private:
  PictureReport inspect_picture(uint16_t material, const std::string& use, const ScanPicture& picture) {
    PictureReport report;
    report.use = use;
    report.file = picture.file.string();
    const Image& image = read_once(picture, report.info);
    if (use == "normal") {
      report.convention = detect_normal_convention(image, charts_in(material, image));
      return report;
    }
    report.is_cut_out = use == "alpha" || report.info.has_alpha;
    if (!report.is_cut_out) return report;
    const int width = std::min(image.width_px, grid_.size_px),
              height = std::min(image.height_px, grid_.size_px);
    const UvRaster raster = rasterise_uvs(scan_, materials_[material].triangles, topology_, material,
                                          {width, height, grid_.max_tests});
    const ScanMaterial& of = scan_.materials[material];
    report.transparent_share =
        use == "alpha" ? transparent_share(surface::read_alpha_picture(of), 0, raster, width, height, of)
                       : transparent_share(image, image.channels - 1, raster, width, height, of);
    return report;
  }

  /// The chart of each texel of a normal map.
  std::vector<uint32_t> charts_in(uint16_t material, const Image& image) const {
    const UvRaster raster = rasterise_uvs(scan_, materials_[material].triangles, topology_, material,
                                          {image.width_px, image.height_px});
    std::vector<uint32_t> region(static_cast<size_t>(image.width_px) * image.height_px, kNoRegion);
    for (size_t i = 0; i < raster.face.size(); ++i)
      if (raster.face[i] != kNoFace) region[i] = chart_of_face_[raster.face[i]];
    return region;
  }

  /// Materials often share a picture: the last one is kept.
  const Image& read_once(const ScanPicture& picture, ImageFileInfo& info) {
    const bool is_plain = picture.view.is_plain();
    if (!is_plain || picture.file != last_file_) last_ = read_image(picture, &last_info_);
    last_file_ = is_plain ? picture.file : std::filesystem::path();
    info = last_info_;
    return last_;
  }

  const Scan& scan_;
  const MeshTopology& topology_;
  const std::vector<MaterialFaces> materials_;
  const UvGrid grid_;
  const std::vector<uint32_t> chart_of_face_;
  std::filesystem::path last_file_;
  Image last_;
  ImageFileInfo last_info_;
};

}  // namespace

InspectReport inspect_scan(const Scan& scan, const std::optional<std::string>& unit_option,
                           bool up_is_given) {
  InspectReport report;
  report.file = scan.file.string();
  report.groups = scan.groups;
  report.has_file_normals = scan.has_file_normals;
  report.removed_offset = scan.removed_offset;
  report.notes = scan.notes;
  report.bounds = bounds_of_faces(scan);
  report.unit = unit_option ? UnitGuess{unit_cm_of(*unit_option), "given by --unit " + *unit_option, ""}
                            : guess_unit(scan);
  if (report.unit.unit_cm && !up_is_given) report.lying = lying_reason(scan, *report.unit.unit_cm);
  const double height_cm =
      (static_cast<double>(report.bounds.high.y) - report.bounds.low.y) * report.unit.unit_cm.value_or(0);
  if (height_cm > kShortestPerson_cm) report.facing = facing_elsewhere(scan);
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  const MeshTopology topology = mesh_topology(scan);
  std::vector<double> face_area(scan.face_count(), 0);
  for (const ScanTriangle& triangle : triangles) face_area[triangle.face] += area_of(scan, triangle);
  count_elements(scan, triangles, report);
  count_bad_faces(scan, topology, face_area, report);
  count_edges(topology, report);
  count_components(topology, face_area, report);
  MaterialInspector inspector(scan, triangles, topology);
  for (size_t m = 0; m < scan.materials.size(); ++m)
    report.materials.push_back(inspector.inspect(static_cast<uint16_t>(m)));
  for (const MissingFile& missing : scan.missing) report.missing.push_back({missing.what, missing.mend});
  report.warnings = inspect_warnings(report, unit_option.has_value());
  return report;
}

}  // namespace ohb::commands
