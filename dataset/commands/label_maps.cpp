#include "dataset/commands/label_maps.h"

#include <algorithm>
#include <cmath>

#include "dataset/labelling/face_colours.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/model_files.h"
#include "dataset/model/regions.h"
#include "dataset/surface/covered_texels.h"

namespace ohb::commands {
namespace {

constexpr int kPreviewEdge_px = 1024;

Image preview_of(const Image& classes) {
  const int step = (std::max(classes.width_px, classes.height_px) + kPreviewEdge_px - 1) / kPreviewEdge_px;
  Image preview(std::max(1, classes.width_px / step), std::max(1, classes.height_px / step), 3);
  for (int y = 0; y < preview.height_px; ++y)
    for (int x = 0; x < preview.width_px; ++x) {
      const float value =
          *classes.pixel(std::min(x * step, classes.width_px - 1), std::min(y * step, classes.height_px - 1));
      const Vec3f colour = class_colour(static_cast<uint8_t>(std::lround(value * 255)));
      std::copy_n(&colour.x, 3, preview.pixel(x, y));
    }
  return preview;
}

/// In the scan's unit: the point that a texel shows.
Vec3f point_of_texel(const Scan& scan, const labelling::MaterialTriangles& of,
                     const surface::TexelCoverage& coverage, int x, int y) {
  const uint32_t owner = coverage.owner_of(x, y);
  const surface::NearestPoint nearest = surface::shown_point(coverage, of.uvs, x, y);
  Vec3f point;
  for (size_t c = 0; c < 3; ++c)
    point +=
        static_cast<float>(nearest.weights[c]) * scan.positions[scan.corners[of.corners[owner][c]].position];
  return point;
}

/// The class at each texel, kUnlabelled where there is no face.
std::vector<uint8_t> classes_of_texels(const Scan& scan, size_t material,
                                       const labelling::MaterialTriangles& of,
                                       const surface::TexelCoverage& coverage, const FaceLabels& labels) {
  const int width = coverage.width_px, height = coverage.height_px;
  std::vector<uint8_t> classes(coverage.owner.size(), kUnlabelled);
  surface::for_each_covered_texel(coverage, [&](int x, int y, uint32_t owner) {
    const uint32_t face = of.face[owner];
    uint8_t& at = classes[static_cast<size_t>(y) * width + x];
    at = labels.face_class[face];
    if (labels.texels && labels.texels->is_refined(face))
      at = labels.texels->class_at(
          material, face, (x + 0.5) / width, (y + 0.5) / height,
          point_of_texel(scan, of, coverage, x, y) * static_cast<float>(labels.unit_cm));
  });
  return classes;
}

void write_weights(const std::filesystem::path& file, const Scan& scan,
                   const labelling::MaterialTriangles& of, const surface::TexelCoverage& coverage,
                   const std::vector<uint8_t>& classes, const labelling::SoftBorders& borders) {
  Image weights(coverage.width_px, coverage.height_px, kClassCount);
  surface::for_each_covered_texel(coverage, [&](int x, int y, uint32_t owner) {
    Vec3f point;
    if (borders.is_near(of.face[owner])) point = point_of_texel(scan, of, coverage, x, y);
    const labelling::ClassValues shares =
        borders.shares_at(of.face[owner], classes[static_cast<size_t>(y) * weights.width_px + x], point);
    std::copy(shares.begin(), shares.end(), weights.pixel(x, y));
  });
  write_exr(file,
            {{"weights", {kClassNames.begin(), kClassNames.end()}, ExrPart::Type::kHalf, std::move(weights)}},
            {});
}

}  // namespace

Vec3f class_colour(uint8_t material_class) {
  if (material_class >= kClassCount) return {0.15f, 0.15f, 0.15f};
  const std::array<float, 3>& colour = kClassColours[material_class];
  return {colour[0], colour[1], colour[2]};
}

std::vector<std::string> write_class_maps(const std::filesystem::path& folder, const Scan& scan,
                                          const FaceLabels& labels) {
  std::vector<std::string> names, without_map;
  for (const ScanMaterial& material : scan.materials) names.push_back(material.name);
  const std::vector<std::string> folders = texture_set_folders(names);
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  for (size_t m = 0; m < scan.materials.size(); ++m) {
    const labelling::MaterialTriangles of = labelling::material_triangles(scan, triangles, m);
    if (of.unusable > 0) without_map.push_back(scan.materials[m].name);
    if (of.unusable > 0 || of.face.empty()) continue;
    const auto [width, height] = labelling::class_map_size(scan.materials[m]);
    const surface::TexelCoverage coverage = surface::cover_texels(of.uvs, width, height);
    const std::filesystem::path maps = folder / "maps" / folders[m];
    make_folders(maps);
    const std::vector<uint8_t> of_texel = classes_of_texels(scan, m, of, coverage, labels);
    Image classes(width, height, 1);
    for (size_t i = 0; i < of_texel.size(); ++i) classes.values[i] = static_cast<float>(of_texel[i]) / 255;
    write_png(maps / "classes.png", classes);
    write_png(maps / "classes_preview.png", preview_of(classes));
    if (labels.borders) write_weights(maps / "weights.exr", scan, of, coverage, of_texel, *labels.borders);
    if (!labels.confidence.empty()) {
      Image confidence(width, height, 1);
      for (size_t i = 0; i < confidence.values.size(); ++i) {
        const uint32_t owner = coverage.owner[i];
        confidence.values[i] = owner == surface::TexelCoverage::kNone ? 1 : labels.confidence[of.face[owner]];
      }
      write_png(maps / "confidence.png", confidence);
    }
  }
  return without_map;
}

}  // namespace ohb::commands
