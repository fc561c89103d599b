// The maps of one texture set: which texel shows which triangle, then each map from the scan's pictures or
// the source, the classes of its faces and the positions of its points.
#include "bake/texture_set_bake.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "bake/jobs.h"
#include "bake/set_report.h"
#include "bake/set_size.h"
#include "bake/uv_charts.h"
#include "dataset/surface/covered_texels.h"
#include "dataset/surface/padding.h"
#include "dataset/surface/picture.h"
#include "dataset/surface/vertex_colours.h"

namespace ohb::bake {
namespace {

SetTriangles triangles_of(const CanonicalMesh& mesh, uint16_t set) {
  const Model& model = mesh.model;
  SetTriangles triangles;
  for (size_t t = 0; t < model.triangles.size(); ++t) {
    const ModelTriangle& triangle = model.triangles[t];
    if (triangle.set != set) continue;
    triangles.index.push_back(static_cast<uint32_t>(t));
    const uint32_t* const corner = mesh.triangles[t].corner;
    triangles.corners.push_back({corner[0], corner[1], corner[2]});
    triangles.uvs.push_back(
        {{model.uvs[triangle.uv[0]], model.uvs[triangle.uv[1]], model.uvs[triangle.uv[2]]}});
  }
  return triangles;
}

std::vector<uint8_t> covered_texels(const surface::TexelCoverage& coverage) {
  std::vector<uint8_t> is_covered(coverage.owner.size());
  for (size_t i = 0; i < is_covered.size(); ++i)
    is_covered[i] = coverage.owner[i] != surface::TexelCoverage::kNone;
  return is_covered;
}

/// So little that clear pixels count only where there are no others.
constexpr float kClearWeight = 1e-8f;

/// Which pixels of a picture count where the map has fewer texels: those that faces show, as far as they
/// are opaque. A picture's background then never mixes into its charts.
surface::ResampleWeights weights_for(const Image& picture, MapSize size, const SetTriangles& triangles,
                                     const Image* alpha) {
  surface::ResampleWeights weights;
  if (picture.width_px <= size.width_px && picture.height_px <= size.height_px) return weights;
  const surface::TexelCoverage shown =
      surface::cover_texels(triangles.uvs, picture.width_px, picture.height_px);
  weights.pixel_weights = Image(picture.width_px, picture.height_px, 1);
  const bool use_alpha =
      alpha && alpha->width_px == picture.width_px && alpha->height_px == picture.height_px;
  for (size_t i = 0; i < shown.owner.size(); ++i)
    weights.pixel_weights.values[i] = shown.owner[i] == surface::TexelCoverage::kNone ? 0.0f
                                      : use_alpha ? std::max(alpha->values[i], kClearWeight)
                                                  : 1.0f;
  return weights;
}

Image constant_image(MapSize size, Vec3f value) {
  Image image(size.width_px, size.height_px, 3);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = value[static_cast<int>(i % 3)];
  return image;
}

/// An image of half the size, rounded down: 1 where any texel of a block is.
std::vector<uint8_t> any_of_blocks(const std::vector<uint8_t>& values, int width_px, int height_px) {
  const int width = std::max(1, width_px / 2), height = std::max(1, height_px / 2);
  std::vector<uint8_t> any(static_cast<size_t>(width) * height);
  for (int y = 0; y < height_px; ++y)
    for (int x = 0; x < width_px; ++x)
      any[static_cast<size_t>(std::min(y / 2, height - 1)) * width + std::min(x / 2, width - 1)] |=
          values[static_cast<size_t>(y) * width_px + x];
  return any;
}

/// What the sides of a mended seam may differ by: half of 1/255 of sRGB, or half a degree.
float mend_tolerance(MapValues values) {
  return values == MapValues::kNormals ? 0.008f : 0.5f / 255;
}

void report_material(const ScanMaterial& material, SetReport& report) {
  report.name = material.name;
  report.diffuse = material.diffuse.file.filename().string();
  report.alpha = material.alpha.file.filename().string();
  report.mask_size = mask_size_of(material);
}

}  // namespace

SetBake::SetBake(const BakeInputs& inputs, uint16_t set, SetReport& report)
    : mesh_(inputs.mesh),
      scan_(inputs.scan),
      table_(inputs.table),
      material_(scan_.materials[mesh_.material_of_set[set]]),
      green_(inputs.options.green.empty() ? surface::GreenChannel::kUp
                                          : inputs.options.green[mesh_.material_of_set[set]]),
      class_weights_(inputs.options.class_weights.empty()
                         ? std::filesystem::path()
                         : inputs.options.class_weights[mesh_.material_of_set[set]]),
      report_(report),
      triangles_(triangles_of(mesh_, set)),
      from_source_(inputs.source != nullptr) {
  const BakeOptions& options = inputs.options;
  const SourceBake* const source = inputs.source;
  report_material(material_, report);
  const MapSize size = size_of_set(material_, triangles_.index.size(), options.size_px,
                                   source ? source->surface->picture_edge_px() : 0);
  coverage_ = surface::cover_texels(triangles_.uvs, size.width_px, size.height_px);
  report_geometry(mesh_.model, triangles_, coverage_, report);
  has_class_ = covered_texels(coverage_);
  has_value_ = has_class_;
  is_inside_.resize(coverage_.flags.size());
  for (size_t i = 0; i < is_inside_.size(); ++i)
    is_inside_[i] = coverage_.flags[i] & surface::TexelCoverage::kCentre;
  const UvCharts charts = find_charts(mesh_.model, triangles_.index, triangles_.uvs, width_px(), height_px());
  seams_ = find_seams(mesh_.model, triangles_with_seams(charts, triangles_.index, triangles_.uvs, coverage_),
                      &inputs.frames);
  report.seam_edges = seams_.size();
  mends_seams_ = options.mends_seams && !seams_.empty();
  if (source) check_overlaps(report, options.source);
  look_at_seams_and_source(source);
  if (!source) return;
  reach_cm_ = std::max(source->outward_cm, source->inward_cm);
  report_source();
  check_misses(report, *source, options.source);
}

void SetBake::look_at_seams_and_source(const SourceBake* source) {
  run_side_by_side({[&] {
                      const size_t all_seams = find_seams(mesh_.model, triangles_.index, nullptr).size();
                      report_.seam_edges_left_out = std::max(all_seams, seams_.size()) - seams_.size();
                      if (mends_seams_)
                        mender_ = std::make_unique<SeamMender>(seams_, is_inside_, width_px(), height_px());
                    },
                    [&] {
                      if (!seams_.empty())
                        band_ = std::make_unique<SeamBand>(seams_, has_class_, width_px(), height_px());
                      if (source)
                        source_ = bake_from_source(mesh_.model, triangles_.index, triangles_.uvs, coverage_,
                                                   *source);
                    }});
}

void SetBake::report_source() {
  struct Counts {
    uint64_t of_result[5] = {}, inward_normals = 0;
    double sum_cm = 0, most_cm = 0;
  };
  std::vector<Counts> rows(height_px());
  tbb::parallel_for(0, height_px(), [&](int y) {
    Counts& row = rows[y];
    for (size_t i = size_t(y) * width_px(); i < size_t(y + 1) * width_px(); ++i) {
      const RayResult result = source_.results[i];
      has_value_[i] = result == RayResult::kHit || result == RayResult::kNearest;
      ++row.of_result[static_cast<int>(result)];
      if (!has_value_[i]) continue;
      row.inward_normals += source_.normal.values[3 * i + 2] <= 0;
      const double distance = std::fabs(source_.height.values[i]);
      row.sum_cm += distance;
      row.most_cm = std::max(row.most_cm, distance);
    }
  });
  double sum_cm = 0;
  for (const Counts& row : rows) {
    report_.hit_texels += row.of_result[static_cast<int>(RayResult::kHit)];
    report_.nearest_texels += row.of_result[static_cast<int>(RayResult::kNearest)];
    report_.missed_texels += row.of_result[static_cast<int>(RayResult::kMissed)];
    report_.back_face_texels += row.of_result[static_cast<int>(RayResult::kBackFace)];
    report_.inward_normal_texels += row.inward_normals;
    sum_cm += row.sum_cm;
    report_.max_distance_cm = std::max(report_.max_distance_cm, row.most_cm);
  }
  const uint64_t found = report_.hit_texels + report_.nearest_texels;
  if (found > 0) report_.mean_distance_cm = sum_cm / static_cast<double>(found);
}

Image SetBake::albedo() {
  if (from_source_) return std::move(source_.albedo);
  const MapSize size{width_px(), height_px()};
  const Vec3f factor = material_.diffuse_factor;
  Image albedo;
  if (material_.diffuse.empty()) {
    albedo = constant_image(size, factor);
  } else {
    Image diffuse = surface::read_colour_picture(material_.diffuse);
    Image alpha;
    if (!material_.alpha.empty()) alpha = surface::read_alpha_picture(material_);
    if (material_.alpha_cutoff)
      for (float& value : alpha.values) value = material_.opacity_of(value);
    const surface::ResampleWeights weights = weights_for(diffuse, size, triangles_, &alpha);
    albedo = surface::resample(std::move(diffuse), size.width_px, size.height_px, weights);
    if (factor.x != 1 || factor.y != 1 || factor.z != 1)
      for (size_t i = 0; i < albedo.values.size(); ++i) albedo.values[i] *= factor[static_cast<int>(i % 3)];
  }
  if (material_.has_vertex_colours)
    surface::multiply_vertex_colours(scan_, triangles_.corners, triangles_.uvs, coverage_, albedo);
  return albedo;
}

Image SetBake::alpha() {
  if (from_source_) return std::move(source_.alpha);
  if (material_.is_opaque()) return {};
  const MapSize size{width_px(), height_px()};
  Image alpha(size.width_px, size.height_px, 1);
  if (material_.alpha.empty()) {
    std::fill(alpha.values.begin(), alpha.values.end(), 1.0f);
  } else {
    Image picture = surface::read_alpha_picture(material_);
    const surface::ResampleWeights weights = weights_for(picture, size, triangles_, nullptr);
    alpha = surface::resample(std::move(picture), size.width_px, size.height_px, weights);
  }
  if (material_.has_vertex_alpha)
    surface::multiply_vertex_colours(scan_, triangles_.corners, triangles_.uvs, coverage_, alpha);
  for (float& value : alpha.values) value = material_.opacity_of(value);
  return alpha;
}

Image SetBake::normal() {
  if (from_source_) return std::move(source_.normal);
  if (material_.normal.empty()) return {};
  report_.normal = material_.normal.file.filename().string();
  report_.normal_green = green_ == surface::GreenChannel::kUp     ? "up"
                         : green_ == surface::GreenChannel::kDown ? "down"
                                                                  : "unclear";
  const MapSize size{width_px(), height_px()};
  Image normal = surface::read_normal_picture(material_.normal, green_ == surface::GreenChannel::kDown,
                                              report_.zero_length_normals);
  const surface::ResampleWeights weights = weights_for(normal, size, triangles_, nullptr);
  normal = surface::resample(std::move(normal), size.width_px, size.height_px, weights);
  surface::normalise_pixels(normal);
  return normal;
}

Image SetBake::displacement() {
  if (from_source_) return std::move(source_.displacement);
  Image map(width_px(), height_px(), 1);
  surface::for_each_covered_texel(coverage_, [&](int x, int y, uint32_t owner) {
    const ModelTriangle& triangle = mesh_.model.triangles[triangles_.index[owner]];
    const surface::NearestPoint point = surface::shown_point(coverage_, triangles_.uvs, x, y);
    double z = 0;
    for (int c = 0; c < 3; ++c) z += point.weights[c] * mesh_.model.positions_cm[triangle.position[c]].z;
    *map.pixel(x, y) = static_cast<float>(z);
  });
  return map;
}

ByteImage SetBake::valid() const {
  ByteImage map(width_px(), height_px(), 1);
  for (size_t i = 0; i < has_value_.size(); ++i) map.values[i] = has_value_[i] ? 255 : 128;
  return map;
}

void SetBake::fill_background(Image& image, const std::vector<uint8_t>& is_covered, bool is_normals) const {
  const std::vector<uint8_t> covered = band_ ? band_->fill(image, is_covered, is_normals) : is_covered;
  if (is_normals)
    surface::pad_normals(image, covered);
  else
    surface::pad(image, covered);
}

void SetBake::finish_seams(Image& image, const char* map, MapValues values) {
  if (seams_.empty() || values == MapValues::kLength) return;
  const bool is_normals = values == MapValues::kNormals;
  MapSeams report;
  report.map = map;
  report.unit = is_normals ? "degrees" : "of 1";
  // Both sides of a class map agree at level 0: each is constant up to the seam, and the band goes on.
  const bool is_mended = is_normals || values == MapValues::kLinearColour;
  if (is_mended && mends_seams_) report.most_changed = mender_->mend(image, values, mend_tolerance(values));
  report.levels = seam_errors(image, seams_, values);
  report_seams(std::move(report));
}

Image SetBake::finished(Image image, const char* map, const std::vector<uint8_t>& is_covered,
                        MapValues values) {
  if (image.values.empty()) return image;
  fill_background(image, is_covered, values == MapValues::kNormals);
  finish_seams(image, map, values);
  return image;
}

/// In the order of kMapKinds, whichever map is ready first.
void SetBake::report_seams(MapSeams seams) {
  const auto place = [](const MapSeams& found) {
    return std::find_if(kMapKinds.begin(), kMapKinds.end(),
                        [&](const MapKind& kind) { return kind.name == found.map; }) -
           kMapKinds.begin();
  };
  const std::lock_guard lock(report_mutex_);
  const auto after = std::find_if(report_.seams.begin(), report_.seams.end(),
                                  [&](const MapSeams& other) { return place(other) > place(seams); });
  report_.seams.insert(after, std::move(seams));
}

void SetBake::report_shipped(const char* map, const std::vector<SeamError>& levels) {
  const std::lock_guard lock(report_mutex_);
  for (MapSeams& seams : report_.seams)
    if (seams.map == map) seams.shipped_levels = levels;
}

std::vector<Image> SetBake::mips_of(const Image& map, const MapKind& kind) {
  const bool is_normals = kind.image == &TextureSet::normal;
  const bool is_mended = mends_seams_ && (is_normals || kind.image == &TextureSet::albedo);
  const MapValues values = is_normals ? MapValues::kNormals : MapValues::kLinearColour;
  std::vector<Image> mips;
  std::vector<SeamError> errors;
  std::vector<uint8_t> is_inside = is_inside_;
  Image plain;  // the level before any mending
  for (const Image* finer = &map; finer->width_px > 1 || finer->height_px > 1; finer = &plain) {
    const int width = std::max(1, finer->width_px / 2), height = std::max(1, finer->height_px / 2);
    const int level = static_cast<int>(mips.size()) + 1;
    is_inside = any_of_blocks(is_inside, finer->width_px, finer->height_px);
    plain = surface::resample(*finer, width, height);
    mips.push_back(plain);
    if (is_normals) surface::normalise_pixels(mips.back());
    if (!is_mended || level >= kSeamLevels) continue;
    SeamMender(seams_, is_inside, width, height, 1).mend(mips.back(), values, mend_tolerance(values));
    errors.push_back(seam_errors(mips.back(), seams_, values, 1).front());
  }
  if (!errors.empty()) report_shipped(kind.name, errors);
  return mips;
}

Image SetBake::take_albedo() {
  return finished(albedo(), "albedo", has_value_, MapValues::kLinearColour);
}

Image SetBake::take_alpha() {
  return finished(alpha(), "alpha", has_value_, MapValues::kPlain);
}

Image SetBake::take_normal() {
  return finished(normal(), "normal", has_value_, MapValues::kNormals);
}

std::array<Image, kMaterialMaps.size()> SetBake::take_class_maps() {
  std::array<Image, kMaterialMaps.size()> maps;
  {
    Image values = class_values();
    fill_background(values, has_class_, false);
    for (Image& map : maps) map = Image(width_px(), height_px(), 1);
    tbb::parallel_for(size_t{0}, has_class_.size(), [&](size_t i) {
      for (size_t m = 0; m < maps.size(); ++m) maps[m].values[i] = values.values[maps.size() * i + m];
    });
  }
  for (size_t m = 0; m < maps.size(); ++m) finish_seams(maps[m], kMaterialMaps[m].name, MapValues::kPlain);
  return maps;
}

Image SetBake::take_displacement() {
  return finished(displacement(), "displacement", has_value_, MapValues::kLength);
}

ByteImage SetBake::debug() const {
  if (!from_source_ && coverage_.overlapping_texels == 0) return {};
  constexpr uint8_t kFull = 255, kQuarter = 64;
  ByteImage map(width_px(), height_px(), 3);
  tbb::parallel_for(size_t{0}, has_class_.size(), [&](size_t i) {
    std::array<uint8_t, 3> colour{};
    if (has_class_[i]) colour = {0, kQuarter, 0};
    if (from_source_) {
      const auto green = [&] {
        const float distance = std::fabs(source_.height.values[i]);
        const float share = reach_cm_ > 0 ? std::min(1.0f, distance / reach_cm_) : 0;
        return static_cast<uint8_t>(kQuarter + std::lround(share * (kFull - kQuarter)));
      };
      if (source_.results[i] == RayResult::kHit) colour = {0, green(), 0};
      if (source_.results[i] == RayResult::kNearest) colour = {0, green(), kFull};
      if (source_.results[i] == RayResult::kMissed) colour = {kFull, 0, 0};
      if (source_.results[i] == RayResult::kBackFace) colour = {kFull, 0, kFull};
    }
    if ((coverage_.flags[i] & surface::TexelCoverage::kOverlapping)) colour = {kFull, kFull, 0};
    std::copy(colour.begin(), colour.end(), &map.values[3 * i]);
  });
  return map;
}

Image SetBake::take_height() {
  return finished(std::move(source_.height), "height", has_value_, MapValues::kLength);
}

Image SetBake::take_object_normal() {
  Image normals = std::move(source_.object_normal);
  if (!normals.values.empty()) surface::pad_normals(normals, has_value_);
  return normals;
}

}  // namespace ohb::bake
