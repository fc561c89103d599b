#include "renderer/validation/speed_accuracy.h"

#include <fmt/format.h>

#include <cmath>

#include "renderer/sampling.h"
#include "renderer/validation/sides.h"
#include "renderer/validation/stopwatch.h"

namespace ohb {
namespace {

constexpr double kAdaptiveThresholds[] = {0.1, 0.03, 0.01};

struct Errors {
  double mean_square = 0, mean_squared_error = 0;
  double relative() const { return std::sqrt(mean_squared_error / mean_square); }
};

Image mean_image(const std::vector<const ImageStack*>& stacks) {
  Image mean(stacks[0]->front().width_px, stacks[0]->front().height_px, 3);
  size_t count = 0;
  for (const ImageStack* stack : stacks)
    for (const Image& image : *stack) {
      ++count;
      for (int y = 0; y < mean.height_px; ++y)
        for (int x = 0; x < mean.width_px; ++x)
          for (int c = 0; c < 3; ++c) mean.pixel(x, y)[c] += image.pixel(x, y)[c];
    }
  for (float& value : mean.values) value /= static_cast<float>(count);
  return mean;
}

/// Over the pixels of the subject (mask above 0). Without a reference: the unbiased variance over the seeds.
Errors errors_of(const ImageStack& stack, const Image& mask, const Image* reference) {
  const Image mean = mean_image({&stack});
  Errors errors;
  size_t count = 0;
  for (int y = 0; y < mask.height_px; ++y)
    for (int x = 0; x < mask.width_px; ++x) {
      if (!(mask.pixel(x, y)[0] > 0)) continue;
      for (int c = 0; c < 3; ++c) {
        const double centre = reference ? reference->pixel(x, y)[c] : mean.pixel(x, y)[c];
        double squares = 0;
        for (const Image& image : stack) squares += std::pow(image.pixel(x, y)[c] - centre, 2);
        errors.mean_squared_error += squares / static_cast<double>(stack.size() - (reference ? 0 : 1));
        errors.mean_square += centre * centre;
        ++count;
      }
    }
  errors.mean_squared_error /= static_cast<double>(count);
  errors.mean_square /= static_cast<double>(count);
  return errors;
}

std::vector<CyclesPass> ladder(const SpeedAccuracySettings& settings) {
  std::vector<CyclesPass> passes;
  for (int spp = 4; spp <= settings.max_spp; spp *= 4)
    passes.push_back({spp, cycles_seeds(settings.seed + static_cast<uint64_t>(spp), settings.seeds), {}});
  return passes;
}

class Measurement {
 public:
  Measurement(const Model& model, const std::vector<Environment>& environments,
              const SpeedAccuracySettings& settings, const std::filesystem::path& scratch)
      : model_(model),
        environments_(environments),
        scratch_(scratch),
        blender_(find_blender(settings.blender)) {
    chart_.model_name = model.name;
    chart_.blender_version = blender_.version;
    chart_.settings = settings;
    for (const Environment& environment : environments) chart_.environments.push_back(environment.name);
    scene_.model = &model;
    scene_.environment = &environments.front();
    scene_.camera = fit_camera(model.positions_cm);
    scene_.size_px = settings.size_px;
    scene_.max_bounces = settings.max_bounces;
    scene_.numbers = CyclesNumbers::kTables;  // what it is fastest with
  }

  SpeedAccuracy run() {
    mask_ = OurRenderer(scene_).maps().mask;
    bool has_subsurface = false;
    for (const TextureSet& set : model_.sets)
      for (const float sss : set.sss.values) has_subsurface |= sss > 0;
    const Image whole = compare_pair("ours", "Cycles", true);
    if (has_subsurface) {
      const Image plain = compare_pair("ours, no subsurface", "Cycles, no subsurface", false);
      chart_.subsurface_effect = errors_of({plain}, mask_, &whole).relative();
    }
    if (environments_.size() > 1) compare_lights();
    mark_front();
    return chart_;
  }

 private:
  std::filesystem::path next_scratch() {
    const std::filesystem::path folder = scratch_ / ("scene_" + std::to_string(scratch_count_++));
    std::filesystem::create_directories(folder);
    return folder;
  }

  void add_points(const std::string& series, const std::vector<CyclesPass>& passes,
                  const std::vector<SideCost>& costs, const std::vector<Errors>& errors) {
    for (size_t i = 0; i < passes.size(); ++i)
      chart_.points.push_back({series, passes[i].spp, passes[i].adaptive_threshold, costs[i].load_s,
                               costs[i].wall_s, costs[i].cpu_s, errors[i].relative()});
  }

  void add_ratio(const SpeedAccuracyPoint& ours, const SpeedAccuracyPoint& cycles) {
    const double work = std::pow(cycles.relative_error / ours.relative_error, 2);
    chart_.ratios.push_back({ours.series, cycles.series, ours.relative_error,
                             (cycles.load_s + work * cycles.wall_s) / (ours.load_s + ours.wall_s),
                             work * cycles.wall_s / ours.wall_s});
  }

  /// Both programs on one light; returns the mean of the best images of both.
  Image compare_pair(const std::string& ours_name, const std::string& cycles_name, bool subsurface) {
    scene_.subsurface = subsurface;
    scene_.passes = ladder(chart_.settings);
    const size_t plain_count = scene_.passes.size();
    if (subsurface)
      for (const double threshold : kAdaptiveThresholds) {
        scene_.passes.push_back(scene_.passes[plain_count - 1]);
        scene_.passes.back().spp = std::min(4 * chart_.settings.max_spp, kMaxCyclesSpp);
        scene_.passes.back().adaptive_threshold = threshold;
      }
    const CyclesSide cycles = render_cycles_side(scene_, blender_, chart_.settings.threads, next_scratch());
    const std::vector<CyclesPass> all = scene_.passes;
    scene_.passes.resize(plain_count);
    const OurSide ours = OurRenderer(scene_).render(scene_.passes, chart_.settings.seed);
    const Image reference = mean_image({&ours.passes.back(), &cycles.passes[plain_count - 1]});
    std::vector<Errors> our_errors, cycles_errors;
    for (const ImageStack& stack : ours.passes) our_errors.push_back(errors_of(stack, mask_, nullptr));
    for (size_t i = 0; i < all.size(); ++i)
      cycles_errors.push_back(
          errors_of(cycles.passes[i], mask_, all[i].adaptive_threshold > 0 ? &reference : nullptr));
    add_points(ours_name, scene_.passes, ours.pass_costs, our_errors);
    const SpeedAccuracyPoint our_best = chart_.points.back();
    add_points(cycles_name, scene_.passes, cycles.pass_costs, cycles_errors);
    const SpeedAccuracyPoint cycles_best = chart_.points.back();
    add_ratio(our_best, cycles_best);
    std::vector<SideCost> costs(plain_count);
    std::vector<Errors> errors(plain_count);
    render_ours({*scene_.environment}, costs, errors);
    add_points(ours_name + ", adaptive", scene_.passes, costs, errors);
    add_ratio(chart_.points.back(), cycles_best);
    for (size_t i = plain_count; i < all.size(); ++i)
      add_points(cycles_name + ", adaptive", {all[i]}, {cycles.pass_costs[i]}, {cycles_errors[i]});
    return reference;
  }

  /// Ours in one pass against Cycles once a light; the error is the root mean square of the lights' own.
  void compare_lights() {
    scene_.subsurface = true;
    scene_.passes = ladder(chart_.settings);
    const std::string lights = fmt::format(", {} lights", environments_.size());
    std::vector<SideCost> costs(scene_.passes.size());
    std::vector<Errors> errors(scene_.passes.size());
    render_ours(environments_, costs, errors);
    add_points("ours" + lights, scene_.passes, costs, errors);
    const SpeedAccuracyPoint our_best = chart_.points.back();
    costs.assign(costs.size(), {});
    errors.assign(errors.size(), {});
    for (const Environment& environment : environments_) {
      scene_.environment = &environment;
      const CyclesSide side = render_cycles_side(scene_, blender_, chart_.settings.threads, next_scratch());
      for (size_t i = 0; i < side.passes.size(); ++i) {
        if (costs[i].load_s == 0) costs[i].load_s = side.pass_costs[i].load_s;
        costs[i].wall_s += side.pass_costs[i].wall_s;
        costs[i].cpu_s += side.pass_costs[i].cpu_s;
        add_light(errors_of(side.passes[i], mask_, nullptr), errors[i]);
      }
    }
    scene_.environment = &environments_.front();
    add_points("Cycles" + lights, scene_.passes, costs, errors);
    add_ratio(our_best, chart_.points.back());
  }

  void add_light(const Errors& of_light, Errors& sum) const {
    sum.mean_squared_error += of_light.mean_squared_error / of_light.mean_square;
    sum.mean_square += 1;
  }

  /// The ladder with adaptive budgets, all lights in one pass.
  void render_ours(const std::vector<Environment>& environments, std::vector<SideCost>& costs,
                   std::vector<Errors>& errors) const {
    const Stopwatch loading;
    const auto scene = build_scene(model_);
    const auto lights = prepare_lights(environments, {});
    const double load_s = loading.wall_s();
    RenderSettings settings;
    settings.size_px = chart_.settings.size_px;
    settings.max_bounces = chart_.settings.max_bounces;
    settings.subsurface = scene_.subsurface;
    settings.adaptive = true;
    for (size_t i = 0; i < scene_.passes.size(); ++i) {
      const size_t seeds = scene_.passes[i].seeds.size();
      std::vector<ImageStack> stacks(environments.size());
      settings.spp = scene_.passes[i].spp;
      const Stopwatch watch;
      for (size_t k = 0; k < seeds; ++k) {
        settings.seed = mix_bits(mix_bits(chart_.settings.seed + 1) + 1000 * i + k);
        std::vector<SampleLight> images = render_lights(*scene, *lights, scene_.camera, 0, settings);
        for (size_t l = 0; l < images.size(); ++l) stacks[l].push_back(std::move(images[l].radiance));
      }
      costs[i].load_s = load_s;
      costs[i].wall_s = watch.wall_s() / static_cast<double>(seeds);
      costs[i].cpu_s = watch.cpu_s() / static_cast<double>(seeds);
      for (const ImageStack& stack : stacks) add_light(errors_of(stack, mask_, nullptr), errors[i]);
    }
  }

  /// Of the points that compute the same thing: one light, subsurface as the model has it.
  void mark_front() {
    const auto compares = [](const SpeedAccuracyPoint& p) {
      return p.series == "ours" || p.series == "ours, adaptive" || p.series == "Cycles" ||
             p.series == "Cycles, adaptive";
    };
    for (SpeedAccuracyPoint& p : chart_.points) {
      p.on_front = compares(p);
      for (const SpeedAccuracyPoint& q : chart_.points)
        if (compares(q) && q.load_s + q.wall_s < p.load_s + p.wall_s && q.relative_error < p.relative_error)
          p.on_front = false;
    }
  }

  const Model& model_;
  const std::vector<Environment>& environments_;
  std::filesystem::path scratch_;
  Blender blender_;
  CyclesScene scene_;
  Image mask_;
  SpeedAccuracy chart_;
  int scratch_count_ = 0;
};

}  // namespace

SpeedAccuracy measure_speed_accuracy(const Model& model, const std::vector<Environment>& environments,
                                     const SpeedAccuracySettings& settings,
                                     const std::filesystem::path& scratch) {
  return Measurement(model, environments, settings, scratch).run();
}

}  // namespace ohb
