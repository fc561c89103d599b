// The maps of one texture set: which texel shows which triangle, then each map from the scan's pictures, the
// classes of its faces and the positions of its points.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "bake/bake.h"
#include "bake/padding.h"
#include "bake/picture.h"
#include "bake/texel_coverage.h"

namespace ohb {
namespace {

/// The triangles of one set, and their UVs in the same order.
struct SetTriangles {
  std::vector<uint32_t> index;  // into Model::triangles
  std::vector<UvTriangle> uvs;
};

SetTriangles triangles_of(const Model& model, uint16_t set) {
  SetTriangles triangles;
  for (size_t t = 0; t < model.triangles.size(); ++t) {
    const ModelTriangle& triangle = model.triangles[t];
    if (triangle.set != set) continue;
    triangles.index.push_back(static_cast<uint32_t>(t));
    triangles.uvs.push_back(
        {{model.uvs[triangle.uv[0]], model.uvs[triangle.uv[1]], model.uvs[triangle.uv[2]]}});
  }
  return triangles;
}

struct Size {
  int width_px, height_px;
};

Size size_of_set(const Image& diffuse, int wanted_px) {
  const bool has_picture = !diffuse.values.empty();
  const int width = has_picture ? diffuse.width_px : kSizeWithoutPicture_px;
  const int height = has_picture ? diffuse.height_px : kSizeWithoutPicture_px;
  const int longer = std::max(width, height);
  const int target = wanted_px > 0 ? wanted_px : std::min(longer, kMaxMapSize_px);
  const auto scaled = [&](int edge) {
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(edge) * target / longer)));
  };
  return {scaled(width), scaled(height)};
}

std::vector<uint8_t> covered_texels(const TexelCoverage& coverage) {
  std::vector<uint8_t> is_covered(coverage.owner.size());
  for (size_t i = 0; i < is_covered.size(); ++i) is_covered[i] = coverage.owner[i] != TexelCoverage::kNone;
  return is_covered;
}

/// So little that clear pixels count only where there are no others.
constexpr float kClearWeight = 1e-8f;

/// Which pixels of a picture count where the map has fewer texels: those that faces show, as far as they
/// are opaque. A picture's background then never mixes into its charts.
ResampleWeights weights_for(const Image& picture, Size size, const SetTriangles& triangles,
                            const Image* alpha) {
  ResampleWeights weights;
  if (picture.width_px <= size.width_px && picture.height_px <= size.height_px) return weights;
  const TexelCoverage shown = cover_texels(triangles.uvs, picture.width_px, picture.height_px);
  weights.pixel_weights = Image(picture.width_px, picture.height_px, 1);
  const bool use_alpha =
      alpha && alpha->width_px == picture.width_px && alpha->height_px == picture.height_px;
  for (size_t i = 0; i < shown.owner.size(); ++i)
    weights.pixel_weights.values[i] = shown.owner[i] == TexelCoverage::kNone ? 0.0f
                                      : use_alpha ? std::max(alpha->values[i], kClearWeight)
                                                  : 1.0f;
  return weights;
}

void set_image_constant(Image& image, Size size, Vec3f value) {
  image = Image(size.width_px, size.height_px, 3);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = value[static_cast<int>(i % 3)];
}

/// Roughness, specular, sss and displacement: what the owner of each texel says at the point nearest to it.
void fill_from_owners(const Model& model, const SetTriangles& triangles, const TexelCoverage& coverage,
                      const MaterialTable& table, TextureSet& set) {
  const int width = coverage.width_px, height = coverage.height_px;
  std::array<ClassMaterial, kClassCount> pure;
  for (int c = 0; c < kClassCount; ++c) {
    std::array<float, kClassCount> shares{};
    shares[c] = 1;
    pure[c] = mix_classes(table, shares);
  }
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const uint32_t owner = coverage.owner_of(x, y);
      if (owner == TexelCoverage::kNone) continue;
      const ModelTriangle& triangle = model.triangles[triangles.index[owner]];
      const ClassMaterial& material = pure[triangle.material_class];
      *set.roughness.pixel(x, y) = material.roughness;
      *set.specular.pixel(x, y) = material.specular;
      *set.sss.pixel(x, y) = material.sss;
      const TexelTriangle in_texels = to_texel_space(triangles.uvs[owner], width, height);
      const NearestPoint point = nearest_point_of_texel(in_texels, width, height, x, y);
      double z = 0;
      for (int c = 0; c < 3; ++c) z += point.weights[c] * model.positions_cm[triangle.position[c]].z;
      *set.displacement.pixel(x, y) = static_cast<float>(z);
    }
  });
}

void report_geometry(const Model& model, const SetTriangles& triangles, const TexelCoverage& coverage,
                     SetReport& report) {
  report.width_px = coverage.width_px;
  report.height_px = coverage.height_px;
  report.triangles = triangles.index.size();
  report.centre_texels = coverage.centre_texels;
  report.footprint_texels = coverage.footprint_texels;
  report.padded_texels = coverage.owner.size() - coverage.centre_texels - coverage.footprint_texels;
  report.overlapping_texels = coverage.overlapping_texels;
  for (size_t t = 0; t < triangles.index.size(); ++t) {
    const double area = area_cm2(model, model.triangles[triangles.index[t]]);
    const Vec2f* const uv = triangles.uvs[t].uv;
    const double uv_area = difference_of_products(double(uv[1].x) - uv[0].x, double(uv[2].y) - uv[0].y,
                                                  double(uv[1].y) - uv[0].y, double(uv[2].x) - uv[0].x);
    report.area_cm2 += area;
    if (uv_area < 0) report.mirrored_area_cm2 += area;
    if (uv_area == 0 && area > 0) ++report.triangles_without_uv_area;
    for (int c = 0; c < 3; ++c)
      report.uvs_outside += uv[c].x < 0 || uv[c].x > 1 || uv[c].y < 0 || uv[c].y > 1;
  }
  const std::vector<uint32_t>& hidden = coverage.hidden_triangles;
  for (uint32_t t : coverage.triangles_without_texel) {
    const ModelTriangle& triangle = model.triangles[triangles.index[t]];
    const double area = area_cm2(model, triangle);
    if (!(area > 0)) continue;
    if (std::binary_search(hidden.begin(), hidden.end(), t)) {
      ++report.hidden_triangles;
      continue;
    }
    ++report.triangles_without_texel;
    report.area_without_texel_cm2 += area;
    if (report.faces_without_texel.size() < BakeReport::kListedFaces)
      report.faces_without_texel.push_back(triangle.source_face);
  }
}

void bake_albedo_and_alpha(const ScanMaterial& material, Image diffuse, Size size,
                           const SetTriangles& triangles, TextureSet& set) {
  Image alpha;
  if (!material.alpha.empty()) alpha = read_alpha_picture(material.alpha);
  if (diffuse.values.empty()) {
    set_image_constant(set.albedo, size, material.diffuse_factor);
  } else {
    const ResampleWeights weights = weights_for(diffuse, size, triangles, &alpha);
    set.albedo = resample(std::move(diffuse), size.width_px, size.height_px, weights);
    const Vec3f factor = material.diffuse_factor;
    if (factor.x != 1 || factor.y != 1 || factor.z != 1)
      for (size_t i = 0; i < set.albedo.values.size(); ++i)
        set.albedo.values[i] *= factor[static_cast<int>(i % 3)];
  }
  if (alpha.values.empty()) return;
  const ResampleWeights weights = weights_for(alpha, size, triangles, nullptr);
  set.alpha = resample(std::move(alpha), size.width_px, size.height_px, weights);
}

void bake_normal(const ScanMaterial& material, GreenChannel green, Size size, const SetTriangles& triangles,
                 TextureSet& set, SetReport& report) {
  if (material.normal.empty()) return;
  report.normal = material.normal.file.filename().string();
  report.normal_green = green == GreenChannel::kUp ? "up" : green == GreenChannel::kDown ? "down" : "unclear";
  Image normal =
      read_normal_picture(material.normal, green == GreenChannel::kDown, report.zero_length_normals);
  const ResampleWeights weights = weights_for(normal, size, triangles, nullptr);
  set.normal = resample(std::move(normal), size.width_px, size.height_px, weights);
  normalise_pixels(set.normal);
}

void pad_all(TextureSet& set, const TexelCoverage& coverage) {
  const std::vector<uint8_t> is_covered = covered_texels(coverage);
  for (Image* image : {&set.albedo, &set.alpha, &set.roughness, &set.specular, &set.sss, &set.displacement})
    if (!image->values.empty()) pad(*image, is_covered);
  if (!set.normal.values.empty()) pad_normals(set.normal, is_covered);
  for (size_t i = 0; i < is_covered.size(); ++i) set.valid.values[i] = is_covered[i] ? 1.0f : 0.5f;
}

}  // namespace

ClassMaterial mix_classes(const MaterialTable& table, const std::array<float, kClassCount>& shares) {
  ClassMaterial mixed;
  for (int c = 0; c < kClassCount; ++c) {
    mixed.specular += shares[c] * table[c].specular;
    mixed.roughness += shares[c] * table[c].roughness;
    mixed.sss += shares[c] * table[c].sss;
  }
  return mixed;
}

TextureSet bake_texture_set(const CanonicalMesh& mesh, const Scan& scan, uint16_t set_index,
                            const MaterialTable& table, const BakeOptions& options, SetReport& report) {
  const uint16_t scan_material = mesh.material_of_set[set_index];
  const ScanMaterial& material = scan.materials[scan_material];
  const SetTriangles triangles = triangles_of(mesh.model, set_index);
  report.name = material.name;
  report.diffuse = material.diffuse.file.filename().string();
  report.alpha = material.alpha.file.filename().string();
  Image diffuse;
  if (!material.diffuse.empty()) diffuse = read_colour_picture(material.diffuse);
  const Size size = size_of_set(diffuse, options.size_px);
  const TexelCoverage coverage = cover_texels(triangles.uvs, size.width_px, size.height_px);
  report_geometry(mesh.model, triangles, coverage, report);

  TextureSet set;
  set.name = material.name;
  bake_albedo_and_alpha(material, std::move(diffuse), size, triangles, set);
  bake_normal(material, options.green.empty() ? GreenChannel::kUp : options.green[scan_material], size,
              triangles, set, report);
  for (Image* image : {&set.roughness, &set.specular, &set.sss, &set.displacement, &set.valid})
    *image = Image(size.width_px, size.height_px, 1);
  fill_from_owners(mesh.model, triangles, coverage, table, set);
  pad_all(set, coverage);
  return set;
}

}  // namespace ohb
