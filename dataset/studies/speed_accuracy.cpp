#include "dataset/studies/speed_accuracy.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "dataset/model/progress.h"
#include "dataset/model/sampling.h"
#include "dataset/model/stopwatch.h"
#include "renderer/quality.h"
#include "renderer/validation/sides.h"

namespace ohb::studies {
namespace {

// Thresholds of Cycles' early stop, and how many times the paths of the best images it may take until then.
constexpr double kAdaptiveThresholds[] = {0.1, 0.03, 0.01};
constexpr int kAdaptiveSpp = 16;
constexpr double kAutoTolerance = 0.02;  // the default of `render`
// Cycles' points that far from our error say what it would take for it.
constexpr double kFarthestError = 4;

struct Errors {
  double mean_square = 0, mean_squared_error = 0;
  double relative() const { return std::sqrt(mean_squared_error / mean_square); }
};

/// What both programs' unbiased images say together, and how far that still is from the truth.
struct Reference {
  Image image;
  double mean_squared_error = 0;
};

Image mean_image(const validation::ImageStack& stack) {
  Image mean(stack.front().width_px, stack.front().height_px, 3);
  for (const Image& image : stack)
    for (int y = 0; y < mean.height_px; ++y)
      for (int x = 0; x < mean.width_px; ++x)
        for (int c = 0; c < 3; ++c)
          mean.pixel(x, y)[c] += image.pixel(x, y)[c] / static_cast<float>(stack.size());
  return mean;
}

/// Over the pixels of the subject (mask above 0). Without a reference: the unbiased variance over the seeds.
Errors errors_of(const validation::ImageStack& stack, const Image& mask, const Reference* reference) {
  const Image centres = reference ? reference->image : mean_image(stack);
  Errors errors;
  size_t count = 0;
  for (int y = 0; y < mask.height_px; ++y)
    for (int x = 0; x < mask.width_px; ++x) {
      if (!(mask.pixel(x, y)[0] > 0)) continue;
      for (int c = 0; c < 3; ++c) {
        const double centre = centres.pixel(x, y)[c];
        double squares = 0;
        for (const Image& image : stack) squares += std::pow(image.pixel(x, y)[c] - centre, 2);
        errors.mean_squared_error += squares / static_cast<double>(stack.size() - (reference ? 0 : 1));
        errors.mean_square += centre * centre;
        ++count;
      }
    }
  errors.mean_squared_error /= static_cast<double>(count);
  errors.mean_square /= static_cast<double>(count);
  // What the reference misses itself is not the images' fault.
  if (reference)
    errors.mean_squared_error = std::max(errors.mean_squared_error - reference->mean_squared_error,
                                         0.01 * reference->mean_squared_error);
  return errors;
}

/// The mean of both, weighted by how sure each is.
Reference reference_of(const validation::ImageStack& ours, const validation::ImageStack& cycles,
                       const Image& mask) {
  const double of_ours = errors_of(ours, mask, nullptr).mean_squared_error / static_cast<double>(ours.size());
  const double of_cycles =
      errors_of(cycles, mask, nullptr).mean_squared_error / static_cast<double>(cycles.size());
  Reference reference{mean_image(ours), 0};
  if (!(of_ours + of_cycles > 0)) return reference;
  const Image other = mean_image(cycles);
  const auto share = static_cast<float>(of_ours / (of_ours + of_cycles));
  for (size_t i = 0; i < other.values.size(); ++i)
    reference.image.values[i] += share * (other.values[i] - reference.image.values[i]);
  reference.mean_squared_error = of_ours * of_cycles / (of_ours + of_cycles);
  return reference;
}

std::vector<validation::CyclesPass> ladder(const SpeedAccuracySettings& settings) {
  std::vector<validation::CyclesPass> passes;
  for (int spp = 4; spp <= settings.max_spp; spp *= 4)
    passes.push_back(
        {spp, validation::cycles_seeds(settings.seed + static_cast<uint64_t>(spp), settings.seeds), {}});
  return passes;
}

class Measurement {
 public:
  Measurement(const Model& model, const std::vector<Environment>& environments,
              const SpeedAccuracySettings& settings, const std::filesystem::path& scratch)
      : model_(model),
        environments_(environments),
        scratch_(scratch),
        blender_(validation::find_blender(settings.blender)) {
    chart_.model_name = model.name;
    chart_.blender_version = blender_.version;
    chart_.settings = settings;
    for (const Environment& environment : environments) chart_.environments.push_back(environment.name);
    scene_.model = &model;
    scene_.environment = &environments.front();
    scene_.camera = fit_camera(model.positions_cm);
    scene_.size_px = settings.size_px;
    scene_.max_bounces = settings.max_bounces;
    scene_.numbers = validation::CyclesNumbers::kTables;  // what it is fastest with
  }

  SpeedAccuracy run() {
    mask_ = validation::OurRenderer(scene_).maps().mask;
    bool has_subsurface = false;
    for (const TextureSet& set : model_.sets)
      for (const float sss : set.sss.values) has_subsurface |= sss > 0;
    const Reference whole = compare("", {environments_.front()}, true);
    if (has_subsurface) {
      const Reference plain = compare(", no subsurface", {environments_.front()}, false);
      chart_.subsurface_effect = errors_of({plain.image}, mask_, &whole).relative();
    }
    if (environments_.size() > 1)
      compare(fmt::format(", {} lights", environments_.size()), environments_, true);
    take_least_loading();
    for (const Comparison& comparison : comparisons_) add_ratio(comparison);
    mark_front();
    return chart_;
  }

 private:
  std::filesystem::path next_scratch() {
    const std::filesystem::path folder = scratch_ / ("scene_" + std::to_string(scratch_count_++));
    std::filesystem::create_directories(folder);
    return folder;
  }

  /// Images of the ladder, [pass][light], and what each pass cost.
  struct Ours {
    std::vector<validation::SideCost> costs;
    std::vector<std::vector<validation::ImageStack>> stacks;
  };
  Ours render_ours(const std::vector<Environment>& environments, renderer::Quality quality, bool adaptive) {
    renderer::RenderSettings settings;
    settings.size_px = chart_.settings.size_px;
    settings.max_bounces = chart_.settings.max_bounces;
    settings.subsurface = scene_.subsurface;
    settings.adaptive = adaptive;
    const std::vector<validation::CyclesPass> passes = ladder(chart_.settings);
    settings.spp = passes.back().spp;  // the job that kAuto chooses for
    const Stopwatch loading;
    const renderer::PreparedScene prepared = renderer::prepare_scene(
        model_, environments, {}, {{scene_.camera, 0}}, settings, {quality, kAutoTolerance, 1});
    const double load_s = chart_.settings.model_read_s +
                          chart_.settings.environment_read_s * static_cast<double>(environments.size()) +
                          loading.wall_s();
    Progress progress("ours", passes.size() * static_cast<size_t>(chart_.settings.seeds));
    Ours ours;
    for (size_t i = 0; i < passes.size(); ++i) {
      const size_t seeds = passes[i].seeds.size();
      ours.stacks.emplace_back(environments.size());
      settings.spp = passes[i].spp;
      const Stopwatch watch;
      for (size_t k = 0; k < seeds; ++k) {
        settings.seed = mix_bits(mix_bits(chart_.settings.seed + 1 + series_count_) + 1000 * i + k);
        std::vector<SampleLight> images = renderer::render_lights(
            {*prepared.lit, *prepared.lights, scene_.camera, 0}, prepared.settings_for(settings));
        for (size_t l = 0; l < images.size(); ++l)
          ours.stacks.back()[l].push_back(std::move(images[l].radiance));
      }
      const auto count = static_cast<double>(seeds);
      ours.costs.push_back({load_s, watch.wall_s() / count, watch.cpu_s() / count, 0});
      progress.add(seeds);
    }
    ++series_count_;
    return ours;
  }

  enum Loads : int { kOnItsOwn = 0, kAsCycles = -1 };  // or as ours of so many lights
  /// A point of ours, and the range of points of Cycles to compare it with.
  struct Comparison {
    size_t ours, first, end;
    std::string cycles;
  };

  void take_least_loading() {
    std::map<int, double> least;
    const auto each = [&](const auto& act) {
      for (size_t i = 0; i < loads_.size(); ++i)
        if (loads_[i] != kOnItsOwn)
          act(least.emplace(loads_[i], chart_.points[i].load_s).first->second, chart_.points[i].load_s);
    };
    each([](double& of_all, double of_one) { of_all = std::min(of_all, of_one); });
    each([](double of_all, double& of_one) { of_one = of_all; });
  }

  /// One point: of several lights the time of all and the root mean square of their relative errors.
  void add_point(const std::string& series, int loads, const validation::CyclesPass& pass,
                 const validation::SideCost& cost, const std::vector<Errors>& of_lights) {
    loads_.push_back(loads);
    double squares = 0;
    for (const Errors& errors : of_lights) squares += errors.mean_squared_error / errors.mean_square;
    chart_.points.push_back({series, pass.spp, pass.adaptive_threshold, cost.load_s, cost.wall_s, cost.cpu_s,
                             std::sqrt(squares / static_cast<double>(of_lights.size()))});
  }
  /// `references`, one a light: of images that may be biased.
  void add_ours(const std::string& series, const Ours& ours, const std::vector<Reference>* references) {
    const int loads = references ? kOnItsOwn : static_cast<int>(ours.stacks.front().size());
    const std::vector<validation::CyclesPass> passes = ladder(chart_.settings);
    for (size_t i = 0; i < passes.size(); ++i) {
      std::vector<Errors> errors;
      for (size_t l = 0; l < ours.stacks[i].size(); ++l)
        errors.push_back(errors_of(ours.stacks[i][l], mask_, references ? &(*references)[l] : nullptr));
      add_point(series, loads, passes[i], ours.costs[i], errors);
    }
  }

  /// Our point against the best that Cycles can do of its points.
  void add_ratio(const Comparison& comparison) {
    const SpeedAccuracyPoint& ours = chart_.points[comparison.ours];
    SpeedAccuracyRatio best;
    for (size_t i = comparison.first; i < comparison.end; ++i) {
      const SpeedAccuracyPoint& p = chart_.points[i];
      const double work = std::pow(p.relative_error / ours.relative_error, 2);
      const bool is_far = p.relative_error > kFarthestError * ours.relative_error && i + 1 < comparison.end;
      const SpeedAccuracyRatio ratio{ours.series,
                                     comparison.cycles,
                                     p.adaptive_threshold,
                                     ours.relative_error,
                                     (p.load_s + work * p.wall_s) / (ours.load_s + ours.wall_s),
                                     work * p.wall_s / ours.wall_s};
      if (best.ours.empty() || (!is_far && ratio.with_loading < best.with_loading)) best = ratio;
    }
    chart_.ratios.push_back(best);
  }

  /// The ladder, and after it the passes that stop by themselves; returns how many do not.
  size_t set_cycles_passes() {
    scene_.passes = ladder(chart_.settings);
    const size_t plain_count = scene_.passes.size();
    for (const double threshold : kAdaptiveThresholds) {
      scene_.passes.push_back(scene_.passes[plain_count - 1]);
      scene_.passes.back().spp = std::min(kAdaptiveSpp * chart_.settings.max_spp, validation::kMaxCyclesSpp);
      scene_.passes.back().adaptive_threshold = threshold;
    }
    return plain_count;
  }

  /// One point a pass, from Cycles' renders and references of each light.
  void add_cycles(const std::string& series, const std::vector<validation::CyclesSide>& cycles,
                  const std::vector<Reference>& references, size_t plain_count) {
    for (size_t i = 0; i < scene_.passes.size(); ++i) {
      const bool stops_early = i >= plain_count;
      validation::SideCost cost{cycles.front().pass_costs[i].load_s, 0, 0, 0};
      std::vector<Errors> errors;
      for (size_t l = 0; l < cycles.size(); ++l) {
        cost.wall_s += cycles[l].pass_costs[i].wall_s;
        cost.cpu_s += cycles[l].pass_costs[i].cpu_s;
        errors.push_back(errors_of(cycles[l].passes[i], mask_, stops_early ? &references[l] : nullptr));
      }
      add_point(series + (stops_early ? ", adaptive" : ""), kAsCycles, scene_.passes[i], cost, errors);
    }
  }

  /// Both programs with these lights: ours all in one pass, Cycles one after the other. The reference is of
  /// the first light.
  Reference compare(const std::string& suffix, const std::vector<Environment>& environments,
                    bool subsurface) {
    scene_.subsurface = subsurface;
    const size_t plain_count = set_cycles_passes();
    std::vector<validation::CyclesSide> cycles;
    for (const Environment& environment : environments) {
      scene_.environment = &environment;
      cycles.push_back(
          validation::render_cycles_side(scene_, blender_, chart_.settings.threads, next_scratch()));
    }
    scene_.environment = &environments_.front();
    const Ours even = render_ours(environments, renderer::Quality::kReference, false);
    std::vector<Reference> references;
    for (size_t l = 0; l < environments.size(); ++l)
      references.push_back(reference_of(even.stacks.back()[l], cycles[l].passes[plain_count - 1], mask_));

    const size_t first = chart_.points.size();
    add_cycles("Cycles" + suffix, cycles, references, plain_count);
    const size_t end = chart_.points.size();
    add_ours("ours" + suffix, even, nullptr);
    comparisons_.push_back({chart_.points.size() - 1, first, end, "Cycles" + suffix});
    add_ours("ours" + suffix + ", adaptive", render_ours(environments, renderer::Quality::kReference, true),
             nullptr);
    comparisons_.push_back({chart_.points.size() - 1, first, end, "Cycles" + suffix});
    if (suffix.empty()) {
      add_ours("ours, auto", render_ours(environments, renderer::Quality::kAuto, true), &references);
      add_ours("ours, fast", render_ours(environments, renderer::Quality::kFast, true), &references);
    }
    return references.front();
  }

  /// Marks the front of the points that compute the same thing: one light, subsurface as the model has it.
  void mark_front() {
    const auto compares = [](const SpeedAccuracyPoint& p) {
      return p.series == "ours" || p.series == "ours, adaptive" || p.series == "Cycles" ||
             p.series == "Cycles, adaptive" || p.series == "ours, auto";
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
  validation::CyclesScene scene_;
  Image mask_;
  SpeedAccuracy chart_;
  std::vector<int> loads_;  // of each point: those of one number load the same
  std::vector<Comparison> comparisons_;
  int scratch_count_ = 0;
  uint64_t series_count_ = 0;  // of ours: each has its own seeds
};

}  // namespace

SpeedAccuracy measure_speed_accuracy(const Model& model, const std::vector<Environment>& environments,
                                     const SpeedAccuracySettings& settings,
                                     const std::filesystem::path& scratch) {
  return Measurement(model, environments, settings, scratch).run();
}

}  // namespace ohb::studies
