#include "dataset/labelling/face_colours.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "dataset/model/lab_colour.h"
#include "dataset/surface/picture.h"
#include "dataset/surface/vertex_colours.h"

namespace ohb::labelling {
namespace {

bool are_usable(const surface::UvTriangle& triangle) {
  for (int i = 0; i < 3; ++i) {
    const Vec2f a = triangle.uv[i], b = triangle.uv[(i + 1) % 3];
    if (!(std::abs(a.x) <= surface::kMaxUv && std::abs(a.y) <= surface::kMaxUv &&
          std::abs(a.x - b.x) <= surface::kMaxUvSpan && std::abs(a.y - b.y) <= surface::kMaxUvSpan))
      return false;
  }
  return true;
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

struct ColourSum {
  double value[3] = {0, 0, 0}, square[3] = {0, 0, 0};
  double count = 0;

  void add(const float* pixel) {
    for (int c = 0; c < 3; ++c) {
      value[c] += pixel[c];
      square[c] += double(pixel[c]) * pixel[c];
    }
    ++count;
  }
  Vec3f mean() const {
    return {static_cast<float>(value[0] / count), static_cast<float>(value[1] / count),
            static_cast<float>(value[2] / count)};
  }
  Vec3f spread() const {
    Vec3f result;
    for (int c = 0; c < 3; ++c) {
      const double mean = value[c] / count;
      result[c] = static_cast<float>(std::sqrt(std::max(0.0, square[c] / count - mean * mean)));
    }
    return result;
  }
};

/// Adds each texel to the face that shows it.
void add_texels(const MaterialTriangles& triangles, const Image& picture, std::vector<ColourSum>& sums) {
  const surface::TexelCoverage coverage = surface::cover_texels(
      triangles.uvs, picture.width_px, picture.height_px, surface::CoveragePasses::kCentres);
  for (size_t i = 0; i < coverage.owner.size(); ++i)
    if (coverage.owner[i] != surface::TexelCoverage::kNone)
      sums[triangles.face[coverage.owner[i]]].add(&picture.values[3 * i]);
  for (uint32_t t : coverage.triangles_without_texel) {
    const surface::UvTriangle& uvs = triangles.uvs[t];
    const Vec3f pixel = pixel_at(picture, (uvs.uv[0] + uvs.uv[1] + uvs.uv[2]) * (1.0f / 3));
    if (sums[triangles.face[t]].count == 0) sums[triangles.face[t]].add(&pixel.x);
  }
}

void to_lab(Image& picture) {
  tbb::parallel_for(0, picture.height_px, [&](int y) {
    for (int x = 0; x < picture.width_px; ++x) {
      float* const p = picture.pixel(x, y);
      const Vec3f lab = linear_to_lab({p[0], p[1], p[2]});
      std::copy_n(&lab.x, 3, p);
    }
  });
}

/// Sums over the pictures of all materials, each turned by `convert` first; `convert(image)` works in place.
template <typename Convert>
std::vector<ColourSum> sum_over_pictures(const Scan& scan, const Convert& convert) {
  std::vector<ColourSum> sums(scan.face_count());
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  for (size_t m = 0; m < scan.materials.size(); ++m) {
    if (scan.materials[m].diffuse.empty()) continue;
    const MaterialTriangles of = material_triangles(scan, triangles, m);
    if (of.face.empty()) continue;
    Image picture = surface::read_colour_picture(scan.materials[m].diffuse);
    if (scan.materials[m].has_vertex_colours)
      surface::multiply_vertex_colours(scan, of.corners, of.uvs,
                                       surface::cover_texels(of.uvs, picture.width_px, picture.height_px,
                                                             surface::CoveragePasses::kCentres),
                                       picture);
    convert(picture);
    add_texels(of, picture, sums);
  }
  return sums;
}

}  // namespace

MaterialTriangles material_triangles(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                                     size_t material) {
  MaterialTriangles of;
  for (const ScanTriangle& triangle : triangles) {
    if (scan.face_material[triangle.face] != material) continue;
    surface::UvTriangle uvs{};
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
    of.corners.push_back({triangle.corner[0], triangle.corner[1], triangle.corner[2]});
    of.uvs.push_back(uvs);
  }
  return of;
}

std::vector<Vec3f> mean_face_colours(const Scan& scan) {
  const std::vector<ColourSum> sums = sum_over_pictures(scan, [](Image&) {});
  std::vector<Vec3f> colours(scan.face_count());
  for (size_t f = 0; f < colours.size(); ++f) {
    const Vec3f factor = scan.materials[scan.face_material[f]].diffuse_factor;
    colours[f] = factor * (sums[f].count > 0 ? sums[f].mean() : surface::mean_vertex_colour(scan, f));
  }
  return colours;
}

std::vector<FaceColour> lab_face_colours(const Scan& scan) {
  const std::vector<ColourSum> sums = sum_over_pictures(scan, to_lab);
  std::vector<FaceColour> colours(scan.face_count());
  for (size_t f = 0; f < colours.size(); ++f) {
    const ScanMaterial& material = scan.materials[scan.face_material[f]];
    if (sums[f].count > 0)
      colours[f] = {sums[f].mean(), sums[f].spread()};
    else
      colours[f].lab = linear_to_lab(material.diffuse_factor * surface::mean_vertex_colour(scan, f));
  }
  return colours;
}

}  // namespace ohb::labelling
