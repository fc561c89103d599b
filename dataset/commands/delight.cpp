#include "dataset/commands/delight.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "bake/ambient_light.h"
#include "dataset/model/model_files.h"
#include "dataset/surface/covered_texels.h"
#include "dataset/surface/picture.h"

namespace ohb::commands {
namespace fs = std::filesystem;
namespace {

constexpr int kSmoothings =
    200;  // of the neighbours' means: what is broader than that many edges is left out

float luminance(Vec3f c) {
  return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

/// One set's picture, the triangle that each of its pixels shows, and what it is divided by.
struct SetPicture {
  Image colour;  // linear, without the factor
  std::vector<uint32_t> index;
  std::vector<surface::UvTriangle> uvs;
  surface::TexelCoverage coverage;
  Image divisor;
};

/// Empty for materials without a picture or with a cut-out.
SetPicture read_set(const bake::CanonicalMesh& mesh, const Scan& scan, uint16_t set) {
  SetPicture picture;
  const ScanMaterial& material = scan.materials[mesh.material_of_set[set]];
  if (material.diffuse.empty() || !material.is_opaque()) return picture;
  const Model& model = mesh.model;
  for (uint32_t t = 0; t < model.triangles.size(); ++t) {
    if (model.triangles[t].set != set) continue;
    picture.index.push_back(t);
    picture.uvs.push_back({{model.uvs[model.triangles[t].uv[0]], model.uvs[model.triangles[t].uv[1]],
                            model.uvs[model.triangles[t].uv[2]]}});
  }
  picture.colour = surface::read_colour_picture(material.diffuse);
  picture.coverage = surface::cover_texels(picture.uvs, picture.colour.width_px, picture.colour.height_px);
  return picture;
}

/// Weighted sums of colours, one a position.
struct PositionColours {
  std::vector<Vec3f> sum;
  std::vector<float> weight;
  void add(uint32_t position, float w, Vec3f colour) {
    sum[position] += w * colour;
    weight[position] += w;
  }
};

/// The pixels around each position; in order, since they are sums of floats.
void add_pixels(const Model& model, const SetPicture& picture, Vec3f factor, PositionColours& colours) {
  const int width = picture.colour.width_px, height = picture.colour.height_px;
  for (int row = 0; row < height; ++row)
    for (int x = 0; x < width; ++x) {
      const uint32_t owner = picture.coverage.owner_of(x, row);
      if (owner == surface::TexelCoverage::kNone) continue;
      const surface::NearestPoint point = surface::shown_point(picture.coverage, picture.uvs, x, row);
      const float* const c = picture.colour.pixel(x, row);
      for (int k = 0; k < 3; ++k)
        colours.add(model.triangles[picture.index[owner]].position[k], static_cast<float>(point.weights[k]),
                    factor * Vec3f{c[0], c[1], c[2]});
    }
}

/// The pixel at each corner, for positions amid fewer pixels than triangles: hardly counts where there are
/// others.
void add_corners(const Model& model, const SetPicture& picture, Vec3f factor, PositionColours& colours) {
  constexpr float kWeight = 1e-3f;
  const int width = picture.colour.width_px, height = picture.colour.height_px;
  const auto at = [](float u, int n) {
    return std::min(n - 1, static_cast<int>((u - std::floor(u)) * static_cast<float>(n)));
  };
  for (size_t t = 0; t < picture.index.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec2f uv = picture.uvs[t].uv[k];
      const float* const c = picture.colour.pixel(at(uv.x, width), height - 1 - at(uv.y, height));
      colours.add(model.triangles[picture.index[t]].position[k], kWeight, factor * Vec3f{c[0], c[1], c[2]});
    }
}

/// Times the mean of the colours that the scan has at each position's corners.
void multiply_at_positions(const bake::CanonicalMesh& mesh, const Scan& scan, std::vector<Vec3f>& colours) {
  std::vector<Vec3f> sum(colours.size());
  std::vector<float> count(colours.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const uint32_t position = mesh.model.triangles[t].position[k];
      sum[position] += scan.corner_colours[mesh.triangles[t].corner[k]].rgb;
      ++count[position];
    }
  for (size_t p = 0; p < colours.size(); ++p)
    if (count[p] > 0) colours[p] = colours[p] * sum[p] * (1 / count[p]);
}

/// The mean colour around each position; the factor where there is no picture.
std::vector<Vec3f> colours_at_positions(const bake::CanonicalMesh& mesh, const Scan& scan,
                                        const std::vector<SetPicture>& pictures) {
  const Model& model = mesh.model;
  PositionColours colours{std::vector<Vec3f>(model.positions_cm.size()),
                          std::vector<float>(model.positions_cm.size())};
  for (size_t s = 0; s < pictures.size(); ++s) {
    const Vec3f factor = scan.materials[mesh.material_of_set[s]].diffuse_factor;
    if (!pictures[s].colour.values.empty()) {
      add_pixels(model, pictures[s], factor, colours);
      add_corners(model, pictures[s], factor, colours);
      continue;
    }
    for (const ModelTriangle& triangle : model.triangles)
      if (triangle.set == s)
        for (uint32_t p : triangle.position) colours.add(p, 1, factor);
  }
  for (size_t p = 0; p < colours.sum.size(); ++p)
    if (colours.weight[p] > 0) colours.sum[p] = colours.sum[p] * (1 / colours.weight[p]);
  if (!scan.corner_colours.empty()) multiply_at_positions(mesh, scan, colours.sum);
  return std::move(colours.sum);
}

/// Positions that share an edge within one class; both ways.
std::vector<std::vector<uint32_t>> neighbours_of(const Model& model, const std::vector<uint8_t>& class_of) {
  std::vector<std::vector<uint32_t>> neighbours(model.positions_cm.size());
  for (const ModelTriangle& t : model.triangles)
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = t.position[k], b = t.position[(k + 1) % 3];
      if (class_of[a] != class_of[b] || class_of[a] == kUnlabelled) continue;
      neighbours[a].push_back(b);
      neighbours[b].push_back(a);
    }
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

/// Values less their mean over the surface around.
std::vector<double> without_broad_part(const std::vector<double>& values,
                                       const std::vector<std::vector<uint32_t>>& neighbours) {
  std::vector<double> broad = values, next(values.size());
  for (int i = 0; i < kSmoothings; ++i) {
    tbb::parallel_for(size_t{0}, values.size(), [&](size_t p) {
      double sum = broad[p];
      for (uint32_t q : neighbours[p]) sum += broad[q];
      next[p] = sum / static_cast<double>(neighbours[p].size() + 1);
    });
    broad.swap(next);
  }
  for (size_t p = 0; p < values.size(); ++p) broad[p] = values[p] - broad[p];
  return broad;
}

/// The class of each position; kUnlabelled where classes meet, or at cut-outs.
std::vector<uint8_t> classes_of(const Model& model, const std::vector<uint8_t>& is_solid) {
  constexpr uint8_t kNothing = 254;
  std::vector<uint8_t> class_of(model.positions_cm.size(), kNothing);
  for (size_t t = 0; t < model.triangles.size(); ++t)
    for (uint32_t p : model.triangles[t].position) {
      const uint8_t here = is_solid[t] ? model.triangles[t].material_class : uint8_t{kUnlabelled};
      class_of[p] = class_of[p] == kNothing || class_of[p] == here ? here : uint8_t{kUnlabelled};
    }
  for (uint8_t& c : class_of)
    if (c == kNothing) c = kUnlabelled;
  return class_of;
}

/// DelightRegion::slope of each class.
std::array<double, kClassCount> slopes_of(const Model& model, const std::vector<uint8_t>& is_solid,
                                          const std::vector<Vec3f>& colour,
                                          const std::vector<Vec3f>& irradiance) {
  const std::vector<uint8_t> class_of = classes_of(model, is_solid);
  const auto neighbours = neighbours_of(model, class_of);
  std::vector<double> texture(colour.size()), light(colour.size());
  for (size_t p = 0; p < colour.size(); ++p) {
    texture[p] = std::log(std::max(1e-2f, luminance(colour[p])));
    light[p] = std::log(std::max(kLeastIrradiance, luminance(irradiance[p])));
  }
  texture = without_broad_part(texture, neighbours);
  light = without_broad_part(light, neighbours);
  constexpr double kMostLog = 0.7;  // a factor of 2: a picture's background, a button
  std::array<double, kClassCount> product{}, square{};
  for (size_t p = 0; p < colour.size(); ++p) {
    if (class_of[p] >= kClassCount) continue;
    product[class_of[p]] += std::clamp(texture[p], -kMostLog, kMostLog) * light[p];
    square[class_of[p]] += light[p] * light[p];
  }
  std::array<double, kClassCount> slopes{};
  for (size_t c = 0; c < kClassCount; ++c) slopes[c] = square[c] > 1e-12 ? product[c] / square[c] : 0;
  return slopes;
}

/// Sums over the texels of a class, before and after the division.
struct ClassSums {
  uint64_t texels = 0, deep = 0;
  double before[3] = {}, after[3] = {}, irradiance = 0;
  float least_irradiance = 1e30f;
};

std::array<ClassSums, kClassCount> sums_of(const Model& model, const std::vector<SetPicture>& pictures) {
  std::array<ClassSums, kClassCount> sums;
  for (const SetPicture& picture : pictures)
    for (size_t i = 0; i < picture.coverage.owner.size(); ++i) {
      const uint32_t owner = picture.coverage.owner[i];
      if (owner == surface::TexelCoverage::kNone) continue;
      ClassSums& of = sums[model.triangles[picture.index[owner]].material_class];
      const float* const e = &picture.divisor.values[3 * i];
      ++of.texels;
      for (int c = 0; c < 3; ++c) {
        const float colour = picture.colour.values[3 * i + static_cast<size_t>(c)];
        of.before[c] += colour;
        of.after[c] += colour / std::max(kLeastIrradiance, e[c]);
      }
      const float here = luminance({e[0], e[1], e[2]});
      of.irradiance += here;
      of.least_irradiance = std::min(of.least_irradiance, here);
      of.deep += here < kLeastIrradiance;
    }
  return sums;
}

DelightRegion region_of(size_t c, const ClassSums& sums, double slope) {
  DelightRegion region;
  const double n = static_cast<double>(sums.texels);
  region.name = kClassNames[c];
  region.texels = sums.texels;
  region.slope = slope;
  region.is_delit = slope >= kLeastSlope;
  region.mean_irradiance = sums.irradiance / n;
  region.least_irradiance = sums.least_irradiance;
  region.mean_luminance =
      luminance({float(sums.before[0] / n), float(sums.before[1] / n), float(sums.before[2] / n)});
  region.deep_share = static_cast<double>(sums.deep) / n;
  return region;
}

/// E at each texel becomes what it is divided by: clamped, and scaled so that the class keeps its mean; 1
/// where nothing is done. Then the picture is divided.
void divide(const Model& model, const std::array<ClassSums, kClassCount>& sums,
            std::array<DelightRegion, kClassCount>& regions, SetPicture& picture) {
  for (size_t i = 0; i < picture.coverage.owner.size(); ++i) {
    const uint32_t owner = picture.coverage.owner[i];
    if (owner == surface::TexelCoverage::kNone) continue;
    const uint8_t material_class = model.triangles[picture.index[owner]].material_class;
    DelightRegion& region = regions[material_class];
    const ClassSums& of = sums[material_class];
    float* const e = &picture.divisor.values[3 * i];
    float* const colour = &picture.colour.values[3 * i];
    for (size_t c = 0; c < 3; ++c) {
      const double keep = of.before[c] > 0 ? of.after[c] / of.before[c] : 1;
      e[c] = region.is_delit ? static_cast<float>(std::max(kLeastIrradiance, e[c]) * keep) : 1.0f;
      colour[c] /= e[c];
    }
    const double gain = 1 / luminance({e[0], e[1], e[2]});
    region.least_gain = std::min(region.least_gain, gain);
    region.most_gain = std::max(region.most_gain, gain);
  }
}

/// What falls on each texel, in the place of a divisor.
void look_up_irradiance(const Model& model, const std::vector<Vec3f>& irradiance, SetPicture& picture) {
  picture.divisor = Image(picture.colour.width_px, picture.colour.height_px, 3);
  std::fill(picture.divisor.values.begin(), picture.divisor.values.end(), 1.0f);
  surface::for_each_covered_texel(picture.coverage, [&](int x, int row, uint32_t owner) {
    const ModelTriangle& triangle = model.triangles[picture.index[owner]];
    const surface::NearestPoint point = surface::shown_point(picture.coverage, picture.uvs, x, row);
    Vec3f e{0, 0, 0};
    for (int k = 0; k < 3; ++k) e += static_cast<float>(point.weights[k]) * irradiance[triangle.position[k]];
    std::copy_n(&e.x, 3, picture.divisor.pixel(x, row));
  });
}

}  // namespace

DelightReport delight(Scan& scan, const bake::CanonicalMesh& mesh, const fs::path& scratch) {
  const Model& model = mesh.model;
  std::vector<SetPicture> pictures;
  std::vector<std::string> names;
  for (size_t s = 0; s < model.sets.size(); ++s) {
    pictures.push_back(read_set(mesh, scan, static_cast<uint16_t>(s)));
    names.push_back(model.sets[s].name);
  }
  std::vector<uint8_t> is_solid(model.triangles.size());
  for (size_t t = 0; t < is_solid.size(); ++t)
    is_solid[t] = scan.materials[mesh.material_of_set[model.triangles[t].set]].is_opaque();
  const std::vector<Vec3f> colour = colours_at_positions(mesh, scan, pictures);
  const std::vector<Vec3f> irradiance = bake::ambient_irradiance(model, is_solid, colour, kDelightRays);
  for (SetPicture& picture : pictures) look_up_irradiance(model, irradiance, picture);
  const std::array<double, kClassCount> slopes = slopes_of(model, is_solid, colour, irradiance);
  const std::array<ClassSums, kClassCount> sums = sums_of(model, pictures);
  std::array<DelightRegion, kClassCount> all;
  for (size_t c = 0; c < kClassCount; ++c)
    if (sums[c].texels > 0) all[c] = region_of(c, sums[c], slopes[c]);
  DelightReport report;
  const std::vector<std::string> folders = texture_set_folders(names);
  for (size_t s = 0; s < pictures.size(); ++s) {
    if (pictures[s].colour.values.empty()) continue;
    divide(model, sums, all, pictures[s]);
    ScanPicture& diffuse = scan.materials[mesh.material_of_set[s]].diffuse;
    const fs::path file = scratch / (std::to_string(s) + "_delit_" + diffuse.file.stem().string() + ".exr");
    write_exr(file, {{"delit", {"R", "G", "B"}, ExrPart::Type::kHalf, std::move(pictures[s].colour)}}, {});
    diffuse = {file, nullptr};
    report.set_folders.push_back(folders[s]);
    report.divisors.push_back(std::move(pictures[s].divisor));
  }
  for (const DelightRegion& region : all)
    if (region.texels > 0) report.regions.push_back(region);
  return report;
}

}  // namespace ohb::commands
