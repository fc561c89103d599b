#include "renderer/validation/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "dataset/model/progress.h"
#include "dataset/model/regions.h"
#include "renderer/sampling.h"
#include "renderer/validation/cycles_scene.h"

namespace ohb {
namespace {

struct Stopwatch {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  std::clock_t processor_start = std::clock();  // of all threads of this process
  double wall_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  double cpu_s() const { return static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC; }
};

ImageStack render_cycles(const CyclesScene& scene, const Blender& blender, int threads,
                         const std::filesystem::path& scratch, Validation& validation) {
  write_cycles_scene(scratch, scene);
  Progress progress("Cycles", scene.seeds.size());
  size_t drawn = 0;
  CyclesRun run = run_cycles(blender, scratch, threads, [&](size_t done, size_t) {
    progress.add(done - drawn);
    drawn = done;
  });
  validation.blender_version = run.version;
  validation.blender_settings = run.settings;
  validation.cycles_cost.load_s = run.load_s;
  ImageStack stack;
  const double count = static_cast<double>(run.renders.size());
  for (CyclesRender& render : run.renders) {
    validation.cycles_cost.wall_s += render.wall_s / count;
    validation.cycles_cost.cpu_s += render.cpu_s / count;
    stack.push_back(std::move(render.rgba));
  }
  return stack;
}

ImageStack render_ours(const CyclesScene& scene, uint64_t seed, Validation& validation, Sample& maps) {
  const Stopwatch loading;
  const auto built = build_scene(*scene.model);
  const auto lights = prepare_lights({*scene.environment}, scene.points);
  validation.our_cost.load_s = loading.wall_s();
  RenderSettings settings;
  settings.size_px = scene.size_px;
  settings.spp = scene.spp;
  settings.max_bounces = scene.max_bounces;
  settings.first_sample_at_centre = true;
  maps = render_maps(*built, scene.camera, scene.turn_rad, settings);
  Progress progress("ours", scene.seeds.size());
  ImageStack stack;
  RenderStatistics statistics;
  const double count = static_cast<double>(scene.seeds.size());
  for (size_t k = 0; k < scene.seeds.size(); ++k) {
    settings.seed = mix_bits(mix_bits(seed) + k);
    const Stopwatch watch;
    std::vector<SampleLight> images =
        render_lights(*built, *lights, scene.camera, scene.turn_rad, settings, &statistics);
    validation.our_cost.wall_s += watch.wall_s() / count;
    validation.our_cost.cpu_s += watch.cpu_s() / count;
    stack.push_back(std::move(images.front().radiance));
    progress.add();
  }
  validation.nonfinite = statistics.nonfinite;
  return stack;
}

std::vector<float> weights_of(const std::vector<uint8_t>& pixels) {
  return std::vector<float>(pixels.begin(), pixels.end());
}

std::vector<RegionRatio> compare_regions(const ImageStack& ours, const ImageStack& cycles,
                                         const Sample& maps) {
  std::vector<RegionRatio> regions;
  const size_t pixels = maps.classes.values.size() / kClassCount;
  std::vector<float> weights(pixels);
  for (int c = 0; c < kClassCount; ++c) {
    for (size_t i = 0; i < pixels; ++i) weights[i] = maps.classes.values[i * kClassCount + c];
    RegionRatio region = compare_region(kClassNames[c], ours, cycles, weights);
    if (region.weight_px > 0) regions.push_back(region);
  }
  regions.push_back(compare_region("whole image", ours, cycles, std::vector<float>(pixels, 1.0f)));
  return regions;
}

double mean_of_channel(const Image& image, int channel) {
  double sum = 0;
  for (size_t i = static_cast<size_t>(channel); i < image.values.size(); i += image.channels)
    sum += image.values[i];
  return sum / (static_cast<double>(image.width_px) * image.height_px);
}

void compare(const ImageStack& ours, const ImageStack& cycles, const Sample& maps, Validation& v) {
  v.coverage = maps.mask;
  v.pixels = pixel_sets(maps.mask, cycles.front());
  v.ours = moments_of(ours);
  v.cycles = moments_of(cycles);
  v.regions = compare_regions(ours, cycles, maps);
  v.band = compare_region("outline", ours, cycles, weights_of(v.pixels.band));
  v.inside_bins = test_bins(ours, cycles, v.pixels.inside);
  v.band_bins = test_bins(ours, cycles, v.pixels.band);
  v.coverage_ours = mean_of_channel(maps.mask, 0);
  for (const Image& image : cycles)
    v.coverage_cycles += mean_of_channel(image, image.channels - 1) / static_cast<double>(cycles.size());
  v.our_cost.mean_squared_error = mean_variance(v.ours, v.pixels.foreground);
  v.cycles_cost.mean_squared_error = mean_variance(v.cycles, v.pixels.foreground);
}

std::string percent(double value) {
  return fmt::format("{:+.3f} %", 100 * value);
}

void worsen(Verdict& verdict, Outcome outcome, const std::string& reason) {
  verdict.outcome = std::max(verdict.outcome, outcome);
  verdict.reasons.push_back(reason);
}

void judge_region(const RegionRatio& region, const ValidationThresholds& limits, Verdict& verdict) {
  const Interval& ratio = region.total;
  if (region.weight_px < limits.least_region_px) return;
  if (ratio.low >= 1 - limits.ratio && ratio.high <= 1 + limits.ratio) return;
  const std::string words =
      fmt::format("{}: ours / Cycles - 1 is {}, 95 % interval {} to {}", region.name,
                  percent(ratio.value - 1), percent(ratio.low - 1), percent(ratio.high - 1));
  if (ratio.low > 1 + limits.ratio || ratio.high < 1 - limits.ratio)
    worsen(verdict, Outcome::kDifference, words + ": a difference.");
  else
    worsen(verdict, Outcome::kUndecided,
           words + fmt::format(": not narrow enough to tell within {:.1f} %; use more --spp or --seeds.",
                               100 * limits.ratio));
}

}  // namespace

SpeedRatio speed_at_equal_error(const Validation& v) {
  const double error = v.cycles_cost.mean_squared_error / v.our_cost.mean_squared_error;
  return {error * v.cycles_cost.wall_s / v.our_cost.wall_s, error * v.cycles_cost.cpu_s / v.our_cost.cpu_s};
}

Verdict judge(const Validation& v) {
  const ValidationThresholds& limits = v.settings.thresholds;
  Verdict verdict;
  for (const CyclesSetting& setting : v.blender_settings)
    if (!setting.same)
      worsen(verdict, Outcome::kDifference,
             fmt::format("Blender did not keep a setting: {} was set to {} and is {}.", setting.name,
                         setting.wanted, setting.found));
  if (v.nonfinite > 0)
    worsen(verdict, Outcome::kDifference,
           fmt::format("{} contributions of ours were NaN or infinite.", v.nonfinite));
  for (const RegionRatio& region : v.regions) judge_region(region, limits, verdict);
  if (v.inside_bins.accepted_share < limits.accepted_share)
    worsen(verdict, Outcome::kDifference,
           fmt::format("{:.2f} % of the 3 x 3 px bins are accepted, not {:.1f} %.",
                       100 * v.inside_bins.accepted_share, 100 * limits.accepted_share));
  if (v.settings.seeds < limits.seeds)
    worsen(
        verdict, Outcome::kUndecided,
        fmt::format("{} seeds a side are too few to judge; {} are needed.", v.settings.seeds, limits.seeds));
  if (verdict.outcome == Outcome::kPass)
    verdict.reasons.push_back(
        fmt::format("Every region's mean is within {:.1f} % of Cycles', 95 % interval included, and {:.2f} % "
                    "of the bins are "
                    "accepted.",
                    100 * limits.ratio, 100 * v.inside_bins.accepted_share));
  return verdict;
}

Validation validate(const Model& model, const Environment& environment, const ValidationSettings& settings,
                    const std::filesystem::path& scratch) {
  const Blender blender = find_blender(settings.blender);
  CyclesScene scene;
  scene.model = &model;
  scene.environment = &environment;
  scene.camera = fit_camera(model.positions_cm);
  scene.turn_rad = turn_of_view(settings.view, settings.view_count);
  scene.size_px = settings.size_px;
  scene.spp = settings.spp;
  scene.max_bounces = settings.max_bounces;
  scene.seeds = cycles_seeds(settings.seed, settings.seeds);
  Validation validation;
  validation.model_name = model.name;
  validation.environment_name = environment.name;
  validation.settings = settings;
  for (const TextureSet& set : model.sets)
    for (const float sss : set.sss.values) validation.has_subsurface |= sss > 0;
  const ImageStack cycles = render_cycles(scene, blender, settings.threads, scratch, validation);
  Sample maps;
  const ImageStack ours = render_ours(scene, settings.seed, validation, maps);
  compare(ours, cycles, maps, validation);
  validation.verdict = judge(validation);
  return validation;
}

}  // namespace ohb
