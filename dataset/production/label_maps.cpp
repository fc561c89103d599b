#include "dataset/production/label_maps.h"

#include <algorithm>
#include <cmath>

#include "bake/picture.h"
#include "bake/texel_coverage.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/model_files.h"
#include "dataset/model/regions.h"

namespace ohb {
namespace {

constexpr int kMaxMapEdge_px = 8192, kPreviewEdge_px = 1024, kSizeWithoutPicture_px = 1024;

/// The triangles of one material that have usable UVs, with their faces.
struct MaterialTriangles {
  std::vector<uint32_t> face;
  std::vector<UvTriangle> uvs;
  size_t unusable = 0;
};

bool are_usable(const UvTriangle& triangle) {
  for (int i = 0; i < 3; ++i) {
    const Vec2f a = triangle.uv[i], b = triangle.uv[(i + 1) % 3];
    if (!(std::abs(a.x) <= kMaxUv && std::abs(a.y) <= kMaxUv && std::abs(a.x - b.x) <= kMaxUvSpan &&
          std::abs(a.y - b.y) <= kMaxUvSpan))
      return false;
  }
  return true;
}

MaterialTriangles triangles_of(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                               size_t material) {
  MaterialTriangles of;
  for (const ScanTriangle& triangle : triangles) {
    if (scan.face_material[triangle.face] != material) continue;
    UvTriangle uvs{};
    bool is_usable = true;
    for (int c = 0; c < 3; ++c) {
      const uint32_t uv = scan.corners[triangle.corner[c]].uv;
      is_usable = is_usable && uv != Corner::kNoUv;
      if (is_usable) uvs.uv[c] = scan.uvs[uv];
    }
    if (!is_usable || !are_usable(uvs)) {
      ++of.unusable;
      continue;
    }
    of.face.push_back(triangle.face);
    of.uvs.push_back(uvs);
  }
  return of;
}

/// The pixel of a picture at a UV coordinate, repeated.
Vec3f pixel_at(const Image& picture, Vec2f uv) {
  const auto index = [](float coordinate, int size) {
    const double part = coordinate - std::floor(static_cast<double>(coordinate));
    return std::min(static_cast<int>(part * size), size - 1);
  };
  const float* const p =
      picture.pixel(index(uv.x, picture.width_px), picture.height_px - 1 - index(uv.y, picture.height_px));
  return {p[0], p[1], p[2]};
}

void add_colours(const MaterialTriangles& triangles, const Image& picture, Vec3f factor,
                 std::vector<Vec3f>& colours) {
  struct Sum {
    double value[3] = {0, 0, 0};
    double count = 0;
  };
  std::vector<Sum> sums(colours.size());
  const auto add = [&](uint32_t face, const float* pixel) {
    for (int c = 0; c < 3; ++c) sums[face].value[c] += pixel[c];
    ++sums[face].count;
  };
  const TexelCoverage coverage =
      cover_texels(triangles.uvs, picture.width_px, picture.height_px, CoveragePasses::kCentres);
  for (size_t i = 0; i < coverage.owner.size(); ++i)
    if (coverage.owner[i] != TexelCoverage::kNone)
      add(triangles.face[coverage.owner[i]], &picture.values[3 * i]);
  for (uint32_t t : coverage.triangles_without_texel) {
    const UvTriangle& uvs = triangles.uvs[t];
    const Vec3f pixel = pixel_at(picture, (uvs.uv[0] + uvs.uv[1] + uvs.uv[2]) * (1.0f / 3));
    if (sums[triangles.face[t]].count == 0) add(triangles.face[t], &pixel.x);
  }
  for (size_t f = 0; f < sums.size(); ++f) {
    if (sums[f].count == 0) continue;
    colours[f] = factor * Vec3f{static_cast<float>(sums[f].value[0] / sums[f].count),
                                static_cast<float>(sums[f].value[1] / sums[f].count),
                                static_cast<float>(sums[f].value[2] / sums[f].count)};
  }
}

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

}  // namespace

Vec3f class_colour(uint8_t material_class) {
  constexpr Vec3f kColours[kClassCount] = {
      {0.93f, 0.68f, 0.55f}, {0.45f, 0.25f, 0.12f}, {0.27f, 0.51f, 0.79f}, {0.85f, 0.25f, 0.22f}};
  return material_class < kClassCount ? kColours[material_class] : Vec3f{0.15f, 0.15f, 0.15f};
}

std::vector<Vec3f> mean_face_colours(const Scan& scan) {
  std::vector<Vec3f> colours(scan.face_count());
  for (size_t f = 0; f < colours.size(); ++f)
    colours[f] = scan.materials[scan.face_material[f]].diffuse_factor;
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  for (size_t m = 0; m < scan.materials.size(); ++m) {
    const ScanMaterial& material = scan.materials[m];
    if (material.diffuse.empty()) continue;
    const MaterialTriangles of = triangles_of(scan, triangles, m);
    if (!of.face.empty())
      add_colours(of, read_colour_picture(material.diffuse), material.diffuse_factor, colours);
  }
  return colours;
}

std::vector<std::string> write_class_maps(const std::filesystem::path& folder, const Scan& scan,
                                          const std::vector<uint8_t>& face_class) {
  std::vector<std::string> names, without_map;
  for (const ScanMaterial& material : scan.materials) names.push_back(material.name);
  const std::vector<std::string> folders = texture_set_folders(names);
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  for (size_t m = 0; m < scan.materials.size(); ++m) {
    const MaterialTriangles of = triangles_of(scan, triangles, m);
    if (of.unusable > 0) without_map.push_back(scan.materials[m].name);
    if (of.unusable > 0 || of.face.empty()) continue;
    const auto [width, height] = map_size(scan.materials[m]);
    const TexelCoverage coverage = cover_texels(of.uvs, width, height);
    Image classes(width, height, 1);
    for (size_t i = 0; i < coverage.owner.size(); ++i) {
      const uint32_t owner = coverage.owner[i];
      const uint8_t index = owner == TexelCoverage::kNone ? uint8_t{kUnlabelled} : face_class[of.face[owner]];
      classes.values[i] = static_cast<float>(index) / 255;
    }
    const std::filesystem::path maps = folder / "maps" / folders[m];
    make_folders(maps);
    write_png(maps / "classes.png", classes);
    write_png(maps / "classes_preview.png", preview_of(classes));
  }
  return without_map;
}

}  // namespace ohb
