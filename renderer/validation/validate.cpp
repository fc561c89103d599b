#include "renderer/validation/validate.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "dataset/model/regions.h"
#include "dataset/model/sampling.h"
#include "dataset/model/stopwatch.h"
#include "renderer/validation/focus.h"

namespace ohb::validation {
namespace {

constexpr uint64_t kFocusSeeds = 0x666f637573;  // apart from the first pass's
constexpr double kHalfWidthShare = 0.4;         // of the threshold: leaves room for the estimate's own error

std::vector<float> weights_of(const std::vector<uint8_t>& pixels) {
  return std::vector<float>(pixels.begin(), pixels.end());
}

struct Region {
  std::string name;
  std::vector<float> weights;  // one a pixel
};

/// The classes that occur, and the whole image.
std::vector<Region> regions_of(const Sample& maps) {
  std::vector<Region> regions;
  const size_t pixels = maps.classes.values.size() / kClassCount;
  for (size_t c = 0; c < kClassCount; ++c) {
    Region region{kClassNames[c], std::vector<float>(pixels)};
    for (size_t i = 0; i < pixels; ++i) region.weights[i] = maps.classes.values[i * kClassCount + c];
    if (std::any_of(region.weights.begin(), region.weights.end(), [](float w) { return w > 0; }))
      regions.push_back(std::move(region));
  }
  regions.push_back({"whole image", std::vector<float>(pixels, 1.0f)});
  return regions;
}

double mean_of_channel(const Image& image, int channel) {
  double sum = 0;
  for (size_t i = static_cast<size_t>(channel); i < image.values.size(); i += image.channels)
    sum += image.values[i];
  return sum / (static_cast<double>(image.width_px) * image.height_px);
}

/// All that the first pass says.
void compare(const ImageStack& ours, const ImageStack& cycles, const std::vector<Region>& regions,
             const Image& mask, Validation& v) {
  const SidesWork work{v.settings.seeds, v.settings.spp, v.settings.spp};
  v.coverage = mask;
  v.pixels = pixel_sets(mask, cycles.front());
  v.ours = moments_of(ours);
  v.cycles = moments_of(cycles);
  for (const Region& region : regions)
    v.regions.push_back({compare_region(region.name, ours, cycles, region.weights), work});
  v.band = {compare_region("outline", ours, cycles, weights_of(v.pixels.band)), work};
  v.inside_bins = test_bins(ours, cycles, v.pixels.inside);
  v.band_bins = test_bins(ours, cycles, v.pixels.band);
  v.coverage_ours = mean_of_channel(mask, 0);
  for (const Image& image : cycles)
    v.coverage_cycles += mean_of_channel(image, image.channels - 1) / static_cast<double>(cycles.size());
  v.our_cost.mean_squared_error = mean_variance(v.ours, v.pixels.foreground);
  v.cycles_cost.mean_squared_error = mean_variance(v.cycles, v.pixels.foreground);
}

/// One more pass for a region whose interval is too wide.
struct Focus {
  size_t region;
  SidesWork work;
  CyclesPass pass;  // of Cycles; ours has its own paths a pixel
};

std::vector<Focus> focus_passes(const Validation& v, const std::vector<Region>& regions) {
  const ValidationSettings& settings = v.settings;
  std::vector<Focus> passes;
  for (size_t i = 0; i < regions.size(); ++i) {
    const RegionRatio& ratio = v.regions[i].ratio;
    if (!is_judged(ratio, settings.thresholds) || settings.focus <= 1) continue;
    const std::optional<SidesWork> work =
        more_work(ratio.total, v.regions[i].work, kHalfWidthShare * settings.thresholds.ratio, settings.focus,
                  kMaxCyclesSpp);
    if (!work) continue;
    const bool whole = regions[i].name == "whole image";
    CyclesPass pass{work->cycles_spp, cycles_seeds(mix_bits(settings.seed ^ kFocusSeeds) + i, work->seeds),
                    boxes_around(whole ? weights_of(v.pixels.foreground) : regions[i].weights,
                                 settings.size_px, settings.size_px)};
    passes.push_back({i, *work, std::move(pass)});
  }
  return passes;
}

CyclesScene scene_of(const Model& model, const Environment& environment, const ValidationSettings& settings) {
  CyclesScene scene;
  scene.model = &model;
  scene.environment = &environment;
  scene.camera = fit_camera(model.positions_cm);
  scene.turn_rad = turn_of_view(settings.view, settings.view_count);
  scene.size_px = settings.size_px;
  scene.max_bounces = settings.max_bounces;
  scene.shading = settings.shading;
  scene.subsurface = settings.subsurface;
  scene.passes = {{settings.spp, cycles_seeds(settings.seed, settings.seeds), {}}};
  return scene;
}

/// Renders the regions that need it again and puts the results in their place.
void focus(CyclesScene& scene, const Blender& blender, const OurRenderer& renderer,
           const std::vector<Region>& regions, const std::filesystem::path& scratch, Validation& v) {
  const std::vector<Focus> focused = focus_passes(v, regions);
  if (focused.empty()) return;
  std::vector<CyclesPass> our_passes;
  scene.passes.clear();
  for (const Focus& one : focused) {
    scene.passes.push_back(one.pass);
    our_passes.push_back(one.pass);
    our_passes.back().spp = one.work.our_spp;
  }
  std::string names;
  for (const Focus& one : focused) names += (names.empty() ? "" : ", ") + regions[one.region].name;
  Progress progress("again, with more paths: " + names, 2 * kStepsOfImage * image_count(our_passes));
  const CyclesSide cycles = render_cycles_side(scene, blender, v.settings.threads, scratch, &progress);
  const OurSide ours = renderer.render(our_passes, v.settings.seed ^ kFocusSeeds, &progress);
  v.nonfinite += ours.nonfinite;
  v.blender_settings.insert(v.blender_settings.end(), cycles.settings.begin(), cycles.settings.end());
  for (size_t i = 0; i < focused.size(); ++i) {
    const Region& region = regions[focused[i].region];
    v.regions[focused[i].region] = {
        compare_region(region.name, ours.passes[i], cycles.passes[i], region.weights), focused[i].work};
  }
}

}  // namespace

SpeedRatio speed_at_equal_error(const Validation& v) {
  const double error = v.cycles_cost.mean_squared_error / v.our_cost.mean_squared_error;
  return {error * v.cycles_cost.wall_s / v.our_cost.wall_s, error * v.cycles_cost.cpu_s / v.our_cost.cpu_s};
}

Validation validate(const Model& model, const Environment& environment, const ValidationSettings& settings,
                    const std::filesystem::path& scratch) {
  const Blender blender = settings.bpy.empty() ? find_blender(settings.blender, settings.shading)
                                               : find_bpy(settings.bpy, settings.shading);
  const Stopwatch watch;
  Validation v;
  v.model_name = model.name;
  v.environment_name = environment.name;
  v.blender_version = blender.version;
  v.settings = settings;
  for (const TextureSet& set : model.sets)
    for (const float sss : set.sss.values) v.has_subsurface |= sss > 0;
  CyclesScene scene = scene_of(model, environment, settings);
  // One bar for both sides: the time left is what Cycles took, until ours shows what it takes.
  std::optional<Progress> progress;
  progress.emplace("Cycles and ours", 2 * kStepsOfImage * image_count(scene.passes));
  if (!settings.kept.empty()) scene.kept = "kept.blend";
  const CyclesSide cycles = render_cycles_side(scene, blender, settings.threads, scratch, &*progress);
  if (!settings.kept.empty()) std::filesystem::rename(scratch / "renders" / scene.kept, settings.kept);
  scene.kept.clear();
  v.cycles_cost = cycles.cost;
  v.blender_settings = cycles.settings;
  const OurRenderer renderer(scene);
  const Sample maps = renderer.maps();
  const OurSide ours = renderer.render(scene.passes, settings.seed, &*progress);
  progress.reset();
  v.our_cost = ours.cost;
  v.nonfinite = ours.nonfinite;
  const std::vector<Region> regions = regions_of(maps);
  compare(ours.passes.front(), cycles.passes.front(), regions, maps.mask, v);
  focus(scene, blender, renderer, regions, scratch, v);
  v.seconds = watch.wall_s();
  v.verdict = judge(v);
  return v;
}

}  // namespace ohb::validation
