#include "dataset/studies/bake_fidelity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/commands/source_materials.h"
#include "dataset/model/progress.h"
#include "dataset/model/sampling.h"
#include "dataset/model/stopwatch.h"
#include "renderer/render.h"

namespace ohb::studies {
namespace {

constexpr int kSharedSeeds = 2;  // two independent differences: their product has no noise bias
constexpr const char* kWhole = "whole image";
constexpr uint64_t kOwnSeeds = 0x62616b65;  // apart from the source's

/// Renders one view of a model.
class ViewRenderer {
 public:
  ViewRenderer(const Model& model, const Environment& environment, const FidelitySettings& settings)
      : settings_(settings),
        scene_(renderer::build_scene(model)),
        lights_(renderer::prepare_lights({environment}, {})),
        camera_(fit_camera(model.positions_cm)),
        turn_rad_(turn_of_view(settings.view, settings.view_count)) {}

  validation::ImageStack images(uint64_t seed, int count) const {
    renderer::RenderSettings render = settings();
    validation::ImageStack stack;
    for (int k = 0; k < count; ++k) {
      render.seed = mix_bits(seed + static_cast<uint64_t>(k));
      stack.push_back(renderer::render_lights({*scene_, *lights_, camera_, turn_rad_}, render)[0].radiance);
    }
    return stack;
  }
  Sample maps() const { return renderer::render_maps(*scene_, camera_, turn_rad_, settings()); }

 private:
  renderer::RenderSettings settings() const {
    renderer::RenderSettings render;
    render.size_px = settings_.size_px;
    render.spp = settings_.spp;
    return render;
  }

  const FidelitySettings& settings_;
  std::shared_ptr<const renderer::Scene> scene_;
  std::shared_ptr<const renderer::LightSet> lights_;
  Camera camera_;
  double turn_rad_;
};

/// What the source's renders give to every comparison.
struct SourceSide {
  validation::ImageStack images;
  Sample maps;
  validation::PixelSets pixels;
  SourceSide(const Model& model, const Environment& environment, const FidelitySettings& settings) {
    const ViewRenderer renderer(model, environment, settings);
    images = renderer.images(settings.seed, settings.seeds);
    maps = renderer.maps();
    pixels = validation::pixel_sets(maps.mask, maps.mask);
  }
};

/// Root of the mean over the foreground of d1 d2 / mean^2, with d1 and d2 the differences of two seeds: the
/// mean squared difference without the noise, since that of one seed knows nothing of the other's.
double relative_error(const validation::ImageStack& baked, const validation::ImageStack& source,
                      const std::vector<uint8_t>& pixels) {
  double product = 0, mean = 0, count = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i]) continue;
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      product += (double(baked[0].values[c]) - source[0].values[c]) *
                 (double(baked[1].values[c]) - source[1].values[c]);
      mean += 0.5 * (double(source[0].values[c]) + source[1].values[c]);
      ++count;
    }
  }
  if (!(mean > 0)) return 0;
  return std::sqrt(std::max(0.0, product / count)) / (mean / count);
}

std::vector<validation::RegionRatio> compare_regions(const validation::ImageStack& baked,
                                                     const validation::ImageStack& source,
                                                     const Sample& maps) {
  std::vector<validation::RegionRatio> regions;
  const size_t pixels = maps.mask.values.size();
  for (size_t c = 0; c < kClassCount; ++c) {
    std::vector<float> weights(pixels);
    for (size_t i = 0; i < pixels; ++i) weights[i] = maps.classes.values[kClassCount * i + c];
    if (std::none_of(weights.begin(), weights.end(), [](float w) { return w > 0; })) continue;
    regions.push_back(validation::compare_region(kClassNames[c], baked, source, weights));
  }
  regions.push_back(validation::compare_region(kWhole, baked, source, std::vector<float>(pixels, 1.0f)));
  return regions;
}

void judge(const FidelityThresholds& limits, FidelityPoint& point) {
  if (point.bins.accepted_share < limits.accepted_share)
    point.failures.push_back(fmt::format("{:.2f} % of the bins differ ({} of {})",
                                         100 * (1 - point.bins.accepted_share),
                                         point.bins.bins - point.bins.accepted, point.bins.bins));
  for (const validation::RegionRatio& region : point.regions) {
    const double off = region.total.value - 1;
    const double limit = region.name == kWhole ? limits.ratio : limits.class_ratio;
    if (region.weight_px >= limits.least_region_px && std::fabs(off) > limit)
      point.failures.push_back(fmt::format("{}: {:+.2f} %", region.name, 100 * off));
  }
  const validation::Interval& own = point.whole.total;
  if (own.low > 1 + limits.ratio || own.high < 1 - limits.ratio)
    point.failures.push_back(fmt::format("whole image, other seeds: {:+.2f} %", 100 * (own.value - 1)));
}

FidelityPoint compare_with(const SourceSide& source, const Model& baked, const Environment& environment,
                           const FidelitySettings& settings) {
  const ViewRenderer renderer(baked, environment, settings);
  FidelityPoint point;
  const validation::ImageStack shared = renderer.images(settings.seed, kSharedSeeds);
  const validation::ImageStack source_shared(source.images.begin(), source.images.begin() + kSharedSeeds);
  point.relative_error = relative_error(shared, source_shared, source.pixels.foreground);
  point.regions = compare_regions(shared, source_shared, source.maps);
  const validation::ImageStack own = renderer.images(settings.seed ^ kOwnSeeds, settings.seeds);
  point.bins = validation::test_bins(own, source.images, source.pixels.inside);
  point.whole = validation::compare_region(kWhole, own, source.images,
                                           std::vector<float>(source.pixels.inside.size(), 1.0f));
  judge(settings.thresholds, point);
  return point;
}

int longest_edge_px(const Model& model) {
  int edge = 0;
  for (const TextureSet& set : model.sets) edge = std::max({edge, set.albedo.width_px, set.albedo.height_px});
  return edge;
}

}  // namespace

bool BakeFidelity::passes() const {
  return std::all_of(points.begin(), points.end(), [&](const FidelityPoint& point) {
    return point.failures.empty() || (!point.is_own_size && point.map_px < picture_px);
  });
}

FidelityPoint compare_models(const Model& baked, const Model& source, const Environment& environment,
                             const FidelitySettings& settings) {
  return compare_with(SourceSide(source, environment, settings), baked, environment, settings);
}

BakeFidelity measure_bake_fidelity(const commands::BakeInputs& inputs, const Environment& environment,
                                   const FidelitySettings& settings) {
  BakeFidelity fidelity;
  fidelity.scan = inputs.scan.file.filename().string();
  fidelity.environment = environment.name;
  fidelity.settings = settings;
  fidelity.picture_px = commands::largest_picture_px(inputs.scan);
  for (const auto& file : inputs.options.class_weights) fidelity.has_soft_borders |= !file.empty();
  Progress progress("bake and render", settings.map_sizes_px.size() + 1);
  const SourceSide source(commands::source_material_model(inputs), environment, settings);
  progress.add();
  for (const int map_px : settings.map_sizes_px) {
    bake::BakeOptions options = inputs.options;
    options.size_px = map_px;
    const Stopwatch watch;
    const Model baked = bake::bake_model(inputs.scan, inputs.regions, inputs.table, options);
    const double cpu_s = watch.cpu_s();
    FidelityPoint point = compare_with(source, baked, environment, settings);
    point.map_px = longest_edge_px(baked);
    point.is_own_size = map_px == 0;
    point.bake_cpu_s = cpu_s;
    fidelity.points.push_back(std::move(point));
    progress.add();
  }
  std::stable_sort(fidelity.points.begin(), fidelity.points.end(),
                   [](const FidelityPoint& a, const FidelityPoint& b) { return a.map_px > b.map_px; });
  return fidelity;
}

}  // namespace ohb::studies
