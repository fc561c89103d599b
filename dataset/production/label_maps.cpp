#include "dataset/production/label_maps.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "dataset/labelling/face_colours.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/model_files.h"
#include "dataset/model/regions.h"

namespace ohb {
namespace {

constexpr int kMaxMapEdge_px = 8192, kPreviewEdge_px = 1024, kSizeWithoutPicture_px = 1024;

/// Width and height of a material's class map.
std::pair<int, int> map_size(const ScanMaterial& material) {
  if (material.diffuse.empty()) return {kSizeWithoutPicture_px, kSizeWithoutPicture_px};
  const Image picture = read_image(material.diffuse);
  const int longer = std::max(picture.width_px, picture.height_px);
  const double scale = std::min(1.0, static_cast<double>(kMaxMapEdge_px) / longer);
  return {std::max(1, static_cast<int>(std::lround(picture.width_px * scale))),
          std::max(1, static_cast<int>(std::lround(picture.height_px * scale)))};
}

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

void write_weights(const std::filesystem::path& file, const Scan& scan, const MaterialTriangles& of,
                   const TexelCoverage& coverage, const SoftBorders& borders) {
  const int width = coverage.width_px, height = coverage.height_px;
  Image weights(width, height, kClassCount);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const uint32_t owner = coverage.owner_of(x, y);
      if (owner == TexelCoverage::kNone) continue;
      Vec3f point;
      if (borders.is_near(of.face[owner])) {
        const TexelTriangle in_texels = to_texel_space(of.uvs[owner], width, height);
        const NearestPoint nearest = nearest_point_of_texel(in_texels, width, height, x, y);
        for (int c = 0; c < 3; ++c)
          point += static_cast<float>(nearest.weights[c]) *
                   scan.positions[scan.corners[of.corners[owner][static_cast<size_t>(c)]].position];
      }
      const ClassValues shares = borders.shares_at(of.face[owner], point);
      std::copy(shares.begin(), shares.end(), weights.pixel(x, y));
    }
  });
  write_exr(file,
            {{"weights", {kClassNames.begin(), kClassNames.end()}, ExrPart::Type::kHalf, std::move(weights)}},
            {});
}

}  // namespace

Vec3f class_colour(uint8_t material_class) {
  constexpr Vec3f kColours[kClassCount] = {
      {0.93f, 0.68f, 0.55f}, {0.45f, 0.25f, 0.12f}, {0.27f, 0.51f, 0.79f}, {0.85f, 0.25f, 0.22f}};
  return material_class < kClassCount ? kColours[material_class] : Vec3f{0.15f, 0.15f, 0.15f};
}

std::vector<std::string> write_class_maps(const std::filesystem::path& folder, const Scan& scan,
                                          const FaceLabels& labels) {
  std::vector<std::string> names, without_map;
  for (const ScanMaterial& material : scan.materials) names.push_back(material.name);
  const std::vector<std::string> folders = texture_set_folders(names);
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  for (size_t m = 0; m < scan.materials.size(); ++m) {
    const MaterialTriangles of = material_triangles(scan, triangles, m);
    if (of.unusable > 0) without_map.push_back(scan.materials[m].name);
    if (of.unusable > 0 || of.face.empty()) continue;
    const auto [width, height] = map_size(scan.materials[m]);
    const TexelCoverage coverage = cover_texels(of.uvs, width, height);
    const std::filesystem::path maps = folder / "maps" / folders[m];
    make_folders(maps);
    const auto of_faces = [&](float background, const auto& value_of) {
      Image image(coverage.width_px, coverage.height_px, 1);
      for (size_t i = 0; i < coverage.owner.size(); ++i)
        image.values[i] =
            coverage.owner[i] == TexelCoverage::kNone ? background : value_of(of.face[coverage.owner[i]]);
      return image;
    };
    const Image classes =
        of_faces(1, [&](uint32_t face) { return static_cast<float>(labels.face_class[face]) / 255; });
    write_png(maps / "classes.png", classes);
    write_png(maps / "classes_preview.png", preview_of(classes));
    if (labels.borders) write_weights(maps / "weights.exr", scan, of, coverage, *labels.borders);
    if (!labels.confidence.empty())
      write_png(maps / "confidence.png", of_faces(1, [&](uint32_t face) { return labels.confidence[face]; }));
  }
  return without_map;
}

}  // namespace ohb
